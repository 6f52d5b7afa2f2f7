// SPDX-License-Identifier: Apache-2.0
// Sheets laid over movable bodies drape and gain no energy.
#include "geometry/field/sample_particles.h"
#include "scenes/soft_fixtures.h"

namespace livegs {
namespace {

using namespace soft_fixtures;

struct Laid {
  // largest energy gain over the start, relative to the sheet's weight times the box height
  double most_gain;
  bool asleep;
};

// Lays a square sheet of 0.6 m and 500 kg/m³ 50 mm above a free box of 0.2 m and `heavier` times its mass on
// a floor, and runs 6 s.
Laid lay(double rate_hz, double thickness_m, double youngs_modulus_pa, double heavier, double turned_rad) {
  World world = world_with(make_elastic_body, rate_hz);
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

// Box corners must not pass the sheet, deep overlaps must not be pushed apart at any depth, and a sheet that
// drapes over a box must not be separated from it as if it were stuck: all of these would add energy.
TEST(SoftSheet, SheetOverAFreeBoxGainsNothing) {
  for (const double stiffness : gate_or_full<double>({1e4, 1e6}, {1e4, 1e5, 1e6})) {
    for (const double heavier : gate_or_full<double>({2.0, 10.0}, {2.0, 3.0, 10.0})) {
      for (const double rate : kRates_hz)
        for (const double turned : {0.0, 0.5}) {
          const Laid laid = lay(rate, 0.01, stiffness, heavier, turned);
          EXPECT_LT(laid.most_gain, 0.02) << stiffness << " Pa, " << heavier << ", turned by " << turned;
        }
    }
  }
}

TEST(SoftSheet, ThinAndThickSheetsGainNothing) {
  for (const double thickness : {0.004, 0.02}) {
    for (const double stiffness : {1e5, 1e6}) {
      const Laid laid = lay(60.0, thickness, stiffness, 3.0, 0.3);
      EXPECT_LT(laid.most_gain, 0.02) << stiffness << " Pa, " << thickness;
    }
  }
}

}  // namespace
}  // namespace livegs
