// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>

#include "geometry/field/sample_particles.h"
#include "scenes/soft_fixtures.h"

namespace livegs::soft_fixtures {

// A block of 0.2 x 0.1 x 0.2 m, 4 kg and 20 kPa, filled by a particle grid. A cell width of 0 selects the
// default.
inline ElasticBodyDescription particle_block(double spacing_m, double cell_width_m) {
  return soft_block(1, {0.2, 0.1, 0.2}, 4.0, 2e4, spacing_m, 0.3, cell_width_m);
}

// The same block as a scene creates it. 0: the default spacing.
inline ElasticBodyDescription sampled_block(double spacing_m = 0.0) {
  ElasticBodyDescription block = particle_block(0.025, 0.0);
  block.particles = sample_particles(box_mesh({0.2, 0.1, 0.2}), kDefaultSamplingDensity, spacing_m);
  return block;
}

// Depth of the lowest point of a sphere of 1 kg and 5 cm radius below the top of the unloaded block on a
// floor, m: the mean over the last of three seconds.
inline double settled_depth_m(ElasticBodyDescription block, double rate, int substeps = 4) {
  World world = world_with(make_elastic_body, rate, {0, -kGravity, 0}, substeps);
  world.add_collider(floor_plane(0.6));
  block.material.loss_factor = 2.0;
  block.world_from_object.position_m = {0, 0.05, 0};
  EXPECT_TRUE(world.add_elastic(block));
  EXPECT_TRUE(world.add_ball(ball(2, {0.004, 0.15, 0.003}, 0.05, 1.0)));
  run_seconds(world, 2.0);
  double height_m = 0.0;
  const int ticks = static_cast<int>(rate);
  for (int i = 0; i < ticks; ++i) {
    world.step();
    height_m += body_state(world, 2).world_from_body.position_m.y() / ticks;
  }
  return 0.1 - (height_m - 0.05);
}

}  // namespace livegs::soft_fixtures
