// SPDX-License-Identifier: Apache-2.0
// Starts without any local indication of the upright orientation, over many seeds. The body must recover its
// rest shape to 1e-3 of its longest side at each rate. The limit is 2 s for a block, and 20 periods of the
// lowest mode at loss factor 0.2 for a leaf and a cord. LIVEGS_RECOVERY_SEEDS=1000 runs 1000 seeds of each
// kind (recovery_thousand, nightly). LIVEGS_RECOVERY_CSV names a file to which the counts are appended
// (tests/bench/results/<machine>/recovery.csv).
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <ostream>
#include <random>
#include <string>
#include <tuple>

#include "known_gaps.h"
#include "scenes/elastic_bodies.h"

namespace livegs::test {
namespace {

struct Recovery {
  const char* name;
  Vector3d size_m;
  double youngs_modulus_pa;
  int seeds;                                        // in the gate; more at night
  double spacing_m = 0.0125, cell_width_m = 0.025;  // 0: the cells that the program chooses

  bool compact() const { return size_m.maxCoeff() < 2.0 * size_m.minCoeff(); }
  ElasticBodyDescription body() const {
    return describe(particle_grid(size_m, spacing_m), youngs_modulus_pa, 0.3, cell_width_m);
  }
};

// Seconds for 20 periods of the lowest mode of a free beam, axial or bending.
double twenty_periods_s(const Vector3d& size_m, double youngs_modulus_pa) {
  const double length = size_m.maxCoeff(), thickness = size_m.minCoeff();
  const double wave_m_s = std::sqrt(youngs_modulus_pa / 1000.0);
  const double axial = M_PI / length, bending = 22.37 / std::sqrt(12.0) * thickness / (length * length);
  return 20.0 * 2.0 * M_PI / (wave_m_s * std::min(axial, bending));
}

void record(const std::string& body, const char* kind, int count, int back, int wound, int inverted) {
  const char* path = std::getenv("LIVEGS_RECOVERY_CSV");
  if (!path) return;
  std::ofstream file(path, std::ios::app);
  if (file.tellp() == 0) file << "body,kind,count,back,wound,inverted\n";
  file << body << "," << kind << "," << count << "," << back << "," << wound << "," << inverted << "\n";
}

class ScrambledBody : public testing::TestWithParam<Recovery> {};

TEST_P(ScrambledBody, RecoversItsRestShape) {
  const Recovery& r = GetParam();
  const char* wanted = std::getenv("LIVEGS_RECOVERY_SEEDS");
  const int seeds = wanted ? std::atoi(wanted) : seed_count(r.seeds);
  const bool compact = r.compact();
  const double seconds = compact ? 2.0 : twenty_periods_s(r.size_m, r.youngs_modulus_pa);
  int wound = 0, inverted = 0;
  for (const double rate_hz : kRates_hz)
    for (int seed = 1; seed <= seeds; ++seed) {
      ElasticBodyDescription body = r.body();
      body.material.loss_factor = 0.2;
      body.cells.scramble = static_cast<uint64_t>(seed);
      Stage stage;
      stage.rate_hz = rate_hz;
      stage.make(body);
      stage.run(seconds);
      ASSERT_TRUE(all_finite(*stage.body)) << "seed " << seed;
      if (rms_distance_from_rest_shape(*stage.body, body.particles) < 1e-3 * r.size_m.maxCoeff()) continue;
      bool upright = true;
      for (const ParticleState& p : stage.body->particles())
        upright = upright && p.deformation_gradient.determinant() > 0;
      ++(upright ? wound : inverted);
    }
  const int runs = seeds * static_cast<int>(kRates_hz.size());
  record(r.name, "scrambled", runs, runs - wound - inverted, wound, inverted);
  EXPECT_EQ(inverted, 0) << "of " << runs;
  EXPECT_LE(wound, (runs + (compact ? 49 : 0)) / 50)
      << "of " << runs;  // 2 %; for blocks one is allowed in a small set
}

INSTANTIATE_TEST_SUITE_P(Recovery, ScrambledBody,
                         testing::Values(Recovery{"Block1e4", Vector3d::Constant(0.1), 1e4, 10},
                                         Recovery{"Block1e5", Vector3d::Constant(0.1), 1e5, 10},
                                         Recovery{"Brick3e4", {0.1, 0.08, 0.06}, 3e4, 10, 0.01, 0.0},
                                         Recovery{"Leaf", {0.2, 0.2, 0.025}, 1e5, 2},
                                         Recovery{"Cord", {0.4, 0.025, 0.025}, 1e5, 4}),
                         [](const auto& one) { return one.param.name; });

// A kind of degenerate start. Each seed gives a different start, and no two differ only by a rotation.
struct Degenerate {
  const char* name;
  int lost;  // number of flattened axes; 0: mirrored
};
void PrintTo(const Degenerate& kind, std::ostream* out) { *out << kind.name; }

class DegenerateStart : public testing::TestWithParam<std::tuple<Recovery, Degenerate>> {
 protected:
  double unit() { return 2.0 * static_cast<double>(random_() >> 11) * 0x1p-53 - 1.0; }

  // Flattens along the body's own axes for the first 12 seeds, then along random axes. Mirrored starts scale
  // their axes to between half and full length.
  Eigen::Matrix3d start(int seed, int lost) {
    random_.seed(static_cast<uint64_t>(seed));
    if (lost ==
        // the first seed is exactly a point, others are within a thousandth of it, half of them inverted
        3) {
      Eigen::Matrix3d rest_of_it;
      for (double& x : rest_of_it.reshaped()) x = seed == 0 ? 0.0 : 1e-3 * unit();
      return rest_of_it;
    }
    Vector3d scale;
    do {
      for (double& x : scale) x = unit() < 0.0 ? -1.0 : 1.0;
    } while (lost == 0 && scale.prod() > 0.0);
    if (lost == 0) scale *= seed < 12 ? 1.0 : 0.75 + 0.25 * unit();
    for (int axis = 0; axis < 3; ++axis) {
      const bool goes = lost == 1 ? axis == seed % 3 : lost == 2 && axis != seed % 3;
      if (goes) scale[axis] = 0.0;
    }
    const Eigen::Matrix3d turn =
        seed < 12 ? Eigen::Matrix3d::Identity()
                  : Eigen::Quaterniond(unit(), unit(), unit(), unit()).normalized().toRotationMatrix();
    return turn * scale.asDiagonal() * turn.transpose();
  }

  std::mt19937_64 random_;
};

TEST_P(DegenerateStart, RecoversItsRestShape) {
  const auto& [r, kind] = GetParam();
  const bool compact = r.compact();
  const char* wanted = std::getenv("LIVEGS_RECOVERY_SEEDS");
  const int starts = wanted ? std::atoi(wanted) : seed_count(r.seeds);
  int back = 0, inverted = 0;
  for (const double rate_hz : kRates_hz)
    for (int seed = 0; seed < starts; ++seed) {
      ElasticBodyDescription body = r.body();
      body.material.loss_factor = 0.2;
      body.initial_deformation = start(seed, kind.lost);
      Stage stage;
      stage.rate_hz = rate_hz;
      stage.make(body);
      ASSERT_GT(rms_distance_from_rest_shape(*stage.body, body.particles), 0.1 * r.size_m.minCoeff())
          << "start is the rest shape";
      stage.run(compact ? 2.0 : twenty_periods_s(r.size_m, r.youngs_modulus_pa));
      ASSERT_TRUE(all_finite(*stage.body)) << "seed " << seed;
      const double distance_m = rms_distance_from_rest_shape(*stage.body, body.particles);
      EXPECT_LT(distance_m, 1e-3 * r.size_m.maxCoeff()) << "seed " << seed << ", from\n"
                                                        << body.initial_deformation;
      if (distance_m < 1e-3 * r.size_m.maxCoeff()) {
        ++back;
      } else {
        const std::vector<ParticleState> now = stage.body->particles();
        inverted += std::any_of(now.begin(), now.end(),
                                [](const auto& p) { return p.deformation_gradient.determinant() <= 0; });
      }
    }
  const int runs = starts * static_cast<int>(kRates_hz.size());
  record(r.name, kind.name, runs, back, runs - back - inverted, inverted);
}

INSTANTIATE_TEST_SUITE_P(
    Recovery, DegenerateStart,
    testing::Combine(testing::Values(Recovery{"Block1e4", Vector3d::Constant(0.1), 1e4, 4},
                                     Recovery{"Block1e5", Vector3d::Constant(0.1), 1e5, 4},
                                     Recovery{"Brick3e4", {0.1, 0.08, 0.06}, 3e4, 4, 0.01, 0.0},
                                     Recovery{"Leaf", {0.2, 0.2, 0.025}, 1e5, 2},
                                     Recovery{"Cord", {0.4, 0.025, 0.025}, 1e5, 2}),
                     testing::Values(Degenerate{"mirrored", 0}, Degenerate{"plane", 1}, Degenerate{"line", 2},
                                     Degenerate{"point", 3})),
    [](const auto& one) {
      return std::string(std::get<0>(one.param).name) + "_" + std::get<1>(one.param).name;
    });

// Kinetic plus elastic energy never exceeds the energy of the fall at any scale: mass 5 mg to 50 kg, size 1
// cm to 10 m, E 1e2 to 1e9 Pa, nu 0.3 and 0.45, at one and four substeps. The time spans the fall, half a
// second after the landing, and one frame of a whole second.
TEST(ElasticScale, StaysFiniteAndGainsNothingAtAnyScale) {
  constexpr double kExploded = 1.5;
  for (const double size : {0.01, 0.3, 10.0}) {
    for (const double mass : gate_or_full<double>({5e-6, 50.0}, {5e-6, 0.05, 50.0})) {
      for (const double stiffness : {1e2, 1e5, 1e9}) {
        for (const double rate_hz : kRates_hz)
          for (const int substeps : {1, 4})
            for (const double nu : gate_or_full<double>({0.45}, {0.3, 0.45})) {
              SCOPED_TRACE(testing::Message()
                           << "nu " << nu << ", " << size << " m, " << mass << " kg, " << stiffness << " Pa, "
                           << rate_hz << " Hz, " << substeps << " substeps");
              ElasticBodyDescription body =
                  describe(particle_grid(Vector3d(1, 0.5, 0.5) * size, size / 8), stiffness, nu);
              body.material.mass_kg = mass;
              body.world_from_object = {
                  {0, size, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.4, Vector3d(1, 0, 1).normalized()))};
              Stage stage;
              stage.rate_hz = rate_hz;
              stage.substeps = substeps;
              stage.gravity_m_s2 = kGravity;
              stage.add_floor();
              stage.make(body);
              const double start = stage.total_energy_j();
              const auto peak = [&](int frames) {
                double energy = 0.0;
                for (int i = 0; i < frames; ++i) {
                  stage.frame();
                  energy = std::max(energy, stage.total_energy_j());
                }
                return energy;
              };
              const double before =
                  peak(static_cast<int>(std::max(1.0, std::sqrt(2.0 * size / 9.81) + 0.5) * rate_hz));
              ASSERT_TRUE(all_finite(*stage.body));
              EXPECT_GT(stage.body->take_contact_total().impulse_n_s, 0.0) << "has not landed";
              // The first step is of first order and g h²/2 too long. A body of 10 m that lands tilted, far
              // below its wave speed, shows a few per cent more energy during the impact.
              report_gap(size > 1.0 ? "scale.landing_energy_of_10_m" : "scale.landing_energy",
                         before / start);
              EXPECT_LT(before, kExploded * start);
              // A frame of a whole second, passed as one step.
              SubstepContext dropped;
              dropped.start_s = stage.time_s;
              dropped.duration_s = 1.0;
              dropped.gravity_m_s2 = kGravity;
              dropped.colliders = stage.colliders;
              stage.body->substep(dropped);
              stage.body->end_frame(1.0);
              stage.time_s += 1.0;
              const double after = peak(10);
              ASSERT_TRUE(all_finite(*stage.body));
              EXPECT_LT(after, 1.0005 * start);
            }
      }
    }
  }
}

// A world never lengthens a step, but a body must survive a step of a whole second.
TEST(ElasticScale, SurvivesAStepOfOneSecond) {
  for (const double stiffness : {1e3, 1e5, 1e7}) {
    ElasticBodyDescription body =
        describe(particle_grid(Vector3d::Constant(0.1), 0.0125), stiffness, 0.3, 0.025);
    body.world_from_object.position_m.y() = 0.2;
    body.material.loss_factor = 0.2;
    Stage stage;
    stage.gravity_m_s2 = kGravity;
    stage.add_floor();
    stage.make(body);
    stage.run(0.3);
    SubstepContext context;
    context.duration_s = 1.0;
    context.gravity_m_s2 = kGravity;
    context.colliders = stage.colliders;
    stage.body->substep(context);
    stage.body->end_frame(1.0);
    stage.run(4.0);
    ASSERT_TRUE(all_finite(*stage.body)) << stiffness;
    // At rest on the floor: within half its size and slower than 2 cm/s.
    EXPECT_GT(stage.body->centre_m().y(), 0.0) << stiffness;
    EXPECT_LT(stage.body->centre_m().y(), 0.08) << stiffness;
    EXPECT_LT(stage.body->energy(kGravity).kinetic_j, 0.5 * 0.02 * 0.02) << stiffness;
  }
}

}  // namespace
}  // namespace livegs::test
