// SPDX-License-Identifier: Apache-2.0
// Soft bodies of several shapes, sampled as in a scene and dropped flat or tilted: their energy after each
// landing, and whether they come to rest.
#include "geometry/field/sample_particles.h"
#include "geometry/surface/shape_mesh.h"
#include "known_gaps.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

constexpr double kNear_m = 0.004;  // closer than this, it touches or may touch within the frame

struct Dropped {
  const char* name;
  TriangleMesh mesh;
};
const std::vector<Dropped>& dropped() {
  static const std::vector<Dropped> all{{"cube", box_mesh(Vector3d::Constant(0.1))},
                                        {"ball", sphere_mesh(0.05, 3)},
                                        {"cylinder", cylinder_mesh(0.04, 0.12)},
                                        {"capsule", capsule_mesh(0.03, 0.12)}};
  return all;
}

class ElasticDrop : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Rates, ElasticDrop, testing::ValuesIn(rates_hz()),
                         [](const auto& one) { return rate_name(one.param); });

// The body takes shorter steps during an impact (CellsBody::in_impact). With its normal steps its energy
// rises during contact, and rubber of nu 0.49 rebounds with more energy than it fell with.
TEST_P(ElasticDrop, GainsNothingAtAnyLandingAndSleeps) {
  constexpr double kAsleep_s = 12.0, kSoon_s = 3.0;
  int cases = 0, soon = 0, sleeping = 0;
  for (const Dropped& thing : dropped()) {
    for (const double tilt_rad : gate_or_full<double>({0.5}, {0.0, 0.5})) {
      for (const double stiffness : gate_or_full<double>({1e4, 1e6}, {1e4, 1e5, 1e6})) {
        SCOPED_TRACE(testing::Message() << thing.name << ", tilt " << tilt_rad << ", " << stiffness << " Pa");
        Stage stage;
        stage.rate_hz = GetParam();
        stage.gravity_m_s2 = kGravity;
        stage.add_floor(0.5);
        ElasticBodyDescription body = describe(sample_particles(thing.mesh), stiffness, 0.3);
        body.material.loss_factor = 0.1;  // the default
        body.world_from_object.position_m = {0, 0.3, 0};
        body.world_from_object.orientation = Eigen::AngleAxisd(tilt_rad, Vector3d(1, 0, 0.5).normalized());
        stage.make(body, make_elastic_body, true);
        const double start_j = stage.total_energy_j();
        double flight_j = start_j, last_flight_j = start_j, in_touch_j = 0.0, asleep_s = INFINITY;
        bool flies = true;
        for (int frame = 0; frame < kAsleep_s * stage.rate_hz && !stage.body->asleep(); ++frame) {
          stage.frame();
          asleep_s = frame / stage.rate_hz;
          double lowest_m = INFINITY;
          for (const ParticleState& particle : stage.body->particles())
            lowest_m = std::min(lowest_m, particle.position_m.y());
          const bool flew = std::exchange(flies, lowest_m > kNear_m);
          const double total_j = stage.total_energy_j();
          if (!flies) in_touch_j = std::max(in_touch_j, total_j);
          if (flies && !flew) {  // it has just left the floor
            EXPECT_LT(total_j, 1.0005 * last_flight_j) << "frame " << frame;
            last_flight_j = std::min(last_flight_j, flight_j);
            flight_j = total_j;
          }
        }
        sleeping += stage.body->asleep();
        report_gap("landing.energy_in_touch", in_touch_j / start_j);
        soon += asleep_s <= kSoon_s;
        ++cases;
      }
    }
  }
  // Stiff bodies bounce longer, by their loss factor. A few keep rocking slowly on a few points.
  report_gap("landing.asleep_within_3_s", static_cast<double>(soon) / cases);
  EXPECT_EQ(sleeping, cases);  // within 12 s
}

// `mach` is the impact speed over the wave speed sqrt(E/rho).
TEST_P(ElasticDrop, ImpactAtWaveSpeedGainsNothing) {
  constexpr double kGain = 1.0005;
  for (const Dropped& thing : dropped()) {
    for (const double stiffness : gate_or_full<double>({1e4}, {1e4, 1e5})) {
      for (const double nu : gate_or_full<double>({0.3, 0.49}, {0.3, 0.45, 0.49})) {
        for (const double tilt_rad : gate_or_full<double>({0.5}, {0.0, 0.5})) {
          for (const double mach : gate_or_full<double>({0.6, 1.3}, {0.2, 0.6, 1.0, 1.3})) {
            SCOPED_TRACE(testing::Message() << thing.name << ", tilt " << tilt_rad << ", " << stiffness
                                            << " Pa, nu " << nu << " at " << mach << " of its waves");
            Stage stage;
            stage.rate_hz = GetParam();
            stage.gravity_m_s2 = kGravity;
            stage.add_floor(0.5);
            ElasticBodyDescription body = describe(sample_particles(thing.mesh), stiffness, nu);
            body.material.loss_factor = 0.1;
            body.world_from_object = {
                {0, 0.13, 0},
                Eigen::Quaterniond(Eigen::AngleAxisd(tilt_rad, Vector3d(1, 0, 0.5).normalized()))};
            body.velocity_m_s = {0, -mach * std::sqrt(stiffness / 1000.0), 0};
            stage.make(body, make_elastic_body, true);
            const double start_j = stage.total_energy_j();
            double in_touch_j = 0.0, in_flight_j = 0.0;
            for (int frame = 0; frame < stage.rate_hz; ++frame) {
              stage.frame();
              double lowest_m = INFINITY;
              for (const ParticleState& particle : stage.body->particles())
                lowest_m = std::min(lowest_m, particle.position_m.y());
              double& most_j = lowest_m > kNear_m ? in_flight_j : in_touch_j;
              most_j = std::max(most_j, stage.total_energy_j());
            }
            EXPECT_LT(in_touch_j, 1.0005 * start_j);
            EXPECT_LT(in_flight_j, kGain * start_j);
          }
        }
      }
    }
  }
}

// A single pass in a fixed order adds some energy to a flattened body, and its material damping hardly acts
// on slow rolling. Rolling resistance (cells_rolling_resistance.cpp) removes that energy.
TEST_P(ElasticDrop, SoftBallSleepsWhereItIsPlaced) {
  for (const double friction : {0.0, 0.5}) {
    for (const double loss_factor : {0.1, 0.5}) {
      SCOPED_TRACE(testing::Message() << "friction " << friction << ", loss factor " << loss_factor);
      Stage stage;
      stage.rate_hz = GetParam();
      stage.gravity_m_s2 = kGravity;
      stage.add_floor(friction);
      ElasticBodyDescription ball = describe(sample_particles(sphere_mesh(0.05, 3)), 1e4, 0.3);
      ball.material.loss_factor = loss_factor;
      ball.world_from_object.position_m = {0, 0.051, 0};
      stage.make(ball, make_elastic_body, true);
      stage.run(3.0);
      EXPECT_TRUE(stage.body->asleep());
      report_gap("landing.ball_aside_m", std::hypot(stage.body->centre_m().x(), stage.body->centre_m().z()));
    }
  }
}

const std::vector<Dropped>& thin() {
  static const std::vector<Dropped> all{{"mat", box_mesh({0.6, 0.01, 0.4})},
                                        {"sheet", box_mesh({0.3, 0.003, 0.2})},
                                        {"strip", box_mesh({0.4, 0.006, 0.05})},
                                        {"rod", cylinder_mesh(0.005, 0.4)}};
  return all;
}

// A sheet may fold over a radius of one cell. Such folds must not count as degenerate cells or as tangles:
// recovery would add energy or pull the folds straight.
TEST_P(ElasticDrop, ThinBodiesGainNothing) {
  for (const Dropped& thing : thin()) {
    for (const double poisson_ratio : gate_or_full<double>({0.49}, {0.3, 0.45, 0.49})) {
      for (const double stiffness : gate_or_full<double>({1e6}, {1e5, 1e6})) {
        for (const double tilt_rad : gate_or_full<double>({0.3, 1.5}, {0.3, 0.8, 1.5})) {
          SCOPED_TRACE(testing::Message() << thing.name << ", nu " << poisson_ratio << ", tilt " << tilt_rad
                                          << ", " << stiffness << " Pa");
          Stage stage;
          stage.rate_hz = GetParam();
          stage.gravity_m_s2 = kGravity;
          stage.add_floor(0.5);
          ElasticBodyDescription body = describe(sample_particles(thing.mesh), stiffness, poisson_ratio);
          body.material.loss_factor = 0.1;  // the default
          body.world_from_object.position_m = {0, 0.6, 0};
          body.world_from_object.orientation = Eigen::AngleAxisd(tilt_rad, Vector3d(1, 0, 0.5).normalized());
          stage.make(body);
          const double start_j = stage.total_energy_j();
          double least_j = start_j, rise_j = 0.0;
          for (int frame = 0; frame < 2.5 * stage.rate_hz; ++frame) {
            stage.frame();
            const double now_j = stage.total_energy_j();
            rise_j = std::max(rise_j, now_j - least_j);
            least_j = std::min(least_j, now_j);
          }
          report_gap("landing.thin_energy",
                     1.0 + rise_j / start_j);  // the largest value is a mat that lands on its edge
          EXPECT_LT(rise_j, 0.5 * start_j);
        }
      }
    }
  }
}

// Free bodies, for 5 s. Shape recovery must not mistake spin-induced bending for a tangle or apply the old
// spin to a new shape.
TEST_P(ElasticDrop, ThinAndSoftBodiesKeepSpinning) {
  std::vector<Dropped> things = thin();
  things.push_back({"bar of 1 kPa", box_mesh({0.4, 0.05, 0.05})});
  for (const Dropped& thing : things) {
    for (const double spin_rad_s : gate_or_full<double>({10.0}, {5.0, 10.0})) {
      SCOPED_TRACE(testing::Message() << thing.name << ", " << spin_rad_s << " rad/s");
      ElasticBodyDescription body =
          describe(sample_particles(thing.mesh), &thing == &things.back() ? 1e3 : 1e6, 0.3);
      body.material.loss_factor = 0.0;
      body.angular_velocity_rad_s = spin_rad_s * Vector3d(1.0, 0.3, 0.2).normalized();
      Stage stage;
      stage.rate_hz = GetParam();
      stage.make(body);
      const BodyEnergy before = stage.body->energy(Vector3d::Zero());
      for (int frame = 0; frame < 5.0 * stage.rate_hz; ++frame) {
        stage.frame();
        const BodyEnergy now = stage.body->energy(Vector3d::Zero());
        ASSERT_LT((now.angular_momentum - before.angular_momentum).norm(),
                  1e-3 * before.angular_momentum.norm())
            << frame;
        ASSERT_LT(now.kinetic_j + now.elastic_j, 1.01 * (before.kinetic_j + before.elastic_j)) << frame;
      }
    }
  }
}

}  // namespace
}  // namespace livegs::test
