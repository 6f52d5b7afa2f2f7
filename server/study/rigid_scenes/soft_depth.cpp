// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/rigid_scenes.h"
#include "study/harness/rigid_stage.h"

namespace livegs::study {

Result<RigidOutcome> soft_depth(const RigidSetup& setup) {
  constexpr double kConverged_m = 0.01444, kRadius_m = 0.05;
  auto made = RigidStage::make(setup);
  if (!made) return made.error();
  RigidStage& stage = *made;
  SoftPart block;
  block.size_m = {0.2, 0.1, 0.2};
  block.mass_kg = 4.0;
  block.youngs_modulus_pa = 2e4;
  block.loss_factor = 2.0;
  block.friction = 0.6;
  block.spacing_m = 0.0125;
  block.cell_width_m = setup.parameter;
  block.position_m = {0, 0.05, 0};
  if (auto added = stage.solver().add_soft(block); !added) return added.error();
  stage.solver().add_floor({}, 0.6);
  RigidPart sphere;
  sphere.radius_m = kRadius_m;
  sphere.friction = 0.5;
  sphere.world_from_part.position_m = {0.004, 0.1 + kRadius_m, 0.003};
  stage.add(sphere);

  stage.run(2.0);
  double height_m = 0.0;
  int frames = 0;
  stage.run(1.0, [&] {
    height_m += stage.motions()[0].world_from_part.position_m.y();
    ++frames;
  });
  const double depth_m = block.size_m.y() - (height_m / frames - kRadius_m);
  return stage.finish({relative("depth", depth_m, kConverged_m, 0.1)});
}

}  // namespace livegs::study
