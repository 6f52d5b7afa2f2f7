// SPDX-License-Identifier: Apache-2.0
// Limp bodies beyond the range that the Gauss-Seidel pass is designed for. With only gravity and a floor none
// may gain energy (cells_energy_limiter.cpp), and each must stay within a plausible place.
#include "geometry/field/sample_particles.h"
#include "geometry/surface/shape_mesh.h"
#include "known_gaps.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

class ElasticBounded : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Rates, ElasticBounded, testing::ValuesIn(rates_hz()),
                         [](const auto& one) { return rate_name(one.param); });

// Half a side times the spin is up to fourteen times the wave speed, so only inertia holds the sheet
// together. Without the energy limiter a sheet of rubber gains 70 % of energy.
TEST_P(ElasticBounded, LimpSheetsKeepSpinning) {
  constexpr double kGain = 1.01;
  for (const double thickness_m : gate_or_full<double>({0.002}, {0.002, 0.006})) {
    for (const double stiffness : gate_or_full<double>({1e3, 1e4}, {3e2, 1e3, 1e4})) {
      for (const double poisson_ratio : {0.3, 0.49}) {
        for (const double spin_rad_s : gate_or_full<double>({30.0}, {10.0, 30.0})) {
          SCOPED_TRACE(testing::Message() << thickness_m << " m, " << stiffness << " Pa, nu " << poisson_ratio
                                          << ", " << spin_rad_s << " rad/s");
          ElasticBodyDescription sheet =
              describe(sample_particles(box_mesh({0.3, 0.3, thickness_m})), stiffness, poisson_ratio);
          sheet.material.loss_factor = 0.1;  // the default
          sheet.angular_velocity_rad_s = spin_rad_s * Vector3d(0.3, 1.0, 0.2).normalized();
          Stage stage;
          stage.rate_hz = GetParam();
          stage.make(sheet);
          const BodyEnergy before = stage.body->energy(Vector3d::Zero());
          double most_j = 0.0, most_turned = 0.0;
          for (int frame = 0; frame < 4.0 * stage.rate_hz; ++frame) {
            stage.frame();
            const BodyEnergy now = stage.body->energy(Vector3d::Zero());
            most_turned = std::max(most_turned, (now.angular_momentum - before.angular_momentum).norm() /
                                                    before.angular_momentum.norm());
            most_j = std::max(most_j, now.kinetic_j + now.elastic_j);
          }
          report_gap("bounded.spin_momentum", most_turned);
          const double gain = most_j / (before.kinetic_j + before.elastic_j);
          if (poisson_ratio > 0.45) {
            report_gap("bounded.rubber_spin_energy", gain);
          } else {
            EXPECT_LT(gain, kGain);
          }
          EXPECT_EQ(stage.body->accuracy().recovery_count, 0);
        }
      }
    }
  }
}

// Rubber sheets and rods that fold under their own weight.
TEST_P(ElasticBounded, SoftRubberGainsNothingOnLanding) {
  struct Thing {
    TriangleMesh mesh;
    double stiffness_pa, density_kg_m3;
  };
  const std::vector<Thing> things{{box_mesh({0.3, 0.3, 0.003}), 3e3, 1000},
                                  {box_mesh({0.3, 0.3, 0.006}), 1e3, 1000},
                                  {box_mesh({0.3, 0.3, 0.012}), 3e3, 1000},
                                  {box_mesh({0.3, 0.3, 0.012}), 1e4, 1000},
                                  {box_mesh({1.3, 0.08, 0.07}), 1.2e4, 120}};
  for (const Thing& thing : things) {
    for (const double poisson_ratio : gate_or_full<double>({0.49}, {0.45, 0.47, 0.49})) {
      SCOPED_TRACE(testing::Message() << &thing - things.data() << ", nu " << poisson_ratio);
      ElasticBodyDescription body =
          describe(sample_particles(thing.mesh), thing.stiffness_pa, poisson_ratio, 0.0, thing.density_kg_m3);
      body.material.loss_factor = 0.1;
      body.world_from_object.position_m = {0, 1.0, 0};
      body.world_from_object.orientation = Eigen::AngleAxisd(0.8, Vector3d(0.2, 0.1, 1.0).normalized());
      Stage stage;
      stage.rate_hz = GetParam();
      stage.gravity_m_s2 = kGravity;
      stage.add_floor(0.6);
      stage.make(body);
      const double start_j = stage.total_energy_j();
      double most_j = 0.0;
      for (int frame = 0; frame < 5.0 * stage.rate_hz; ++frame) {
        stage.frame();
        most_j = std::max(most_j, stage.total_energy_j());
      }
      EXPECT_LT(most_j / start_j, 1.0005);
      EXPECT_LT(stage.total_energy_j(), start_j);
      EXPECT_EQ(stage.body->accuracy().recovery_count, 0);
    }
  }
}

// A force of 100 N, 85 times the weight, acts on the end of a clamped strip of 100 kPa: a strain of 3.3 over
// its section. The hand must slip off such an extreme stretch; otherwise it keeps pulling cells that contract
// on their own.
TEST_P(ElasticBounded, HandSlipsOffOverstretchedStrip) {
  ElasticBodyDescription strip = describe(sample_particles(box_mesh({0.4, 0.003, 0.1})), 1e5, 0.3);
  strip.material.loss_factor = 0.1;
  strip.regions.push_back(fixed_box({-0.3, -0.1, -0.1}, {-0.15, 0.1, 0.1}));
  Stage stage;
  stage.rate_hz = GetParam();
  stage.make(strip);
  PointSpring hand;
  hand.target_m = {5.0, 0.0, 0.0};
  hand.stiffness_n_m = 2000.0;
  hand.damping_n_s_m = 20.0;
  hand.max_force_n = 100.0;
  stage.forces.push_back({{0.2, 0, 0}, Vector3d::Zero(), &hand});
  double farthest_m = 0.0, most_j = 0.0;
  for (int frame = 0; frame < 3.0 * stage.rate_hz; ++frame) {
    stage.frame();
    farthest_m = std::max(farthest_m, stage.body->world_point({0.2, 0, 0}).x());
    const BodyEnergy now = stage.body->energy(kNoGravity);
    most_j = std::max(most_j, now.kinetic_j + now.elastic_j);
  }
  EXPECT_GT(farthest_m, 0.25);  // it is stretched
  EXPECT_LT(farthest_m, 1.6);   // four times its length from the clamp, 1.2 m, plus a margin for swinging
  EXPECT_LT(most_j, 60.0);      // a strain of 3 everywhere stores E V 9 / 2 = 54 J
  stage.forces.clear();
  stage.run(5.0);
  EXPECT_LT((stage.body->world_point({0.2, 0, 0}) - Vector3d(-0.15, 0, 0)).norm(), 0.36);
  EXPECT_LT(stage.total_energy_j(), 0.05 * most_j);
  EXPECT_EQ(stage.body->accuracy().recovery_count, 0);
}

}  // namespace
}  // namespace livegs::test
