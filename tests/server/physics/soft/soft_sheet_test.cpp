// SPDX-License-Identifier: Apache-2.0
// Sheets laid over things that are free to move: they drape, and gain nothing.
#include "geometry/field/sample_particles.h"
#include "known_gaps.h"
#include "scenes/soft_fixtures.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

struct Laid {
  double most_gain;  // of energy over the start, of what the sheet may fall by: its weight times the height
                     // of the box
  bool asleep;
};

// A sheet of 0.6 m square and 500 kg/m³, 50 mm over a free box of 0.2 m and `heavier` times its mass, on a
// floor, for 6 s.
Laid lay(double rate_hz, double thickness_m, double youngs_modulus_pa, double heavier, double turned_rad) {
  World world = world_with(ElasticSolver::Cells, rate_hz);
  world.add_collider(floor_plane(0.5));
  ElasticBodyDescription sheet =
      test::describe(sample_particles(box_mesh({0.6, thickness_m, 0.6})), youngs_modulus_pa, 0.3, 0.0, 500.0);
  sheet.object_id = 1;
  sheet.material.loss_factor = 0.1;
  sheet.world_from_object.position_m = {0, 0.25, 0};
  const double mass_kg = sheet.material.mass_kg;
  RigidBodyDescription box = box_body(2, Vector3d::Constant(0.2), heavier * mass_kg);
  box.world_from_object.position_m = {0, 0.1005, 0};
  box.world_from_object.orientation = Eigen::AngleAxisd(turned_rad, Vector3d::UnitY());
  EXPECT_TRUE(world.add_rigid(box) && world.add_elastic(sheet));
  const auto total = [&] {
    const BodyEnergy energy = world.energy();
    return energy.kinetic_j + energy.elastic_j + energy.gravity_j;
  };
  const double start_j = total(), falls_j = mass_kg * kGravity * 0.2;
  Laid laid{0, false};
  for (int tick = 0; tick < 6 * rate_hz; ++tick) {
    world.step();
    laid.most_gain = std::max(laid.most_gain, (total() - start_j) / falls_j);
  }
  laid.asleep = world.elastic_body(1)->asleep();
  return laid;
}

// When corners of the box were let through and overlaps pushed apart however deep, they had up to 27 times
// what they fell with, and were drawn round the box.
TEST(SoftSheet, LaidOverAFreeBoxGainsNothing) {
  for (const double stiffness : {1e4, 1e5, 1e6}) {
    for (const double heavier : gate_or_full<double>({2.0, 10.0}, {2.0, 3.0, 10.0})) {
      for (const double rate : kRates_hz)
        for (const double turned : {0.0, 0.5}) {
          const Laid laid = lay(rate, 0.01, stiffness, heavier, turned);
          // Of the limp ones that their own weight folds sharply one in three reads more for a moment.
          if (stiffness < 5e4) {
            report_gap("sheet.limp_gain", laid.most_gain);
          } else {
            EXPECT_LT(laid.most_gain, 0.02) << stiffness << " Pa, " << heavier << ", turned by " << turned;
          }
        }
    }
  }
}

TEST(SoftSheet, ThinAndThickOnesToo) {
  for (const double thickness : {0.004, 0.02}) {
    for (const double stiffness : {1e5, 1e6}) {
      const Laid laid = lay(60.0, thickness, stiffness, 3.0, 0.3);
      EXPECT_LT(laid.most_gain, 0.02) << stiffness << " Pa, " << thickness;
    }
  }
}

}  // namespace
}  // namespace livegs
