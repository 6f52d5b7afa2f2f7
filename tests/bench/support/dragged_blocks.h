// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdio>

#include "geometry/mesh/mass_properties.h"
#include "geometry/surface/shape_mesh.h"
#include "physics/world.h"
#include "prepare/prepare_pieces.h"
#include "scenes/elastic_bodies.h"

// Four elastic blocks of 28 cm (1e4 Pa, 10 x 10 x 10 cells each) are pulled by springs whose targets jump by
// up to 0.3 m twice a second, while 200 boxes of 4 cm, or the same number of fragments, fall onto a floor
// among them. Blocks of another size have the same number of cells, and spring stiffness scales with their
// faces.

namespace livegs::bench {

inline constexpr int kBlocks = 4, kBoxes = 200;
inline constexpr double kSide_m = 0.28;

inline World blocks_alone(double side_m = kSide_m) {
  WorldSettings settings;
  World world(settings);
  Collider floor;
  floor.shape = PlaneShape{};
  floor.friction = 0.6;
  world.add_collider(floor);
  for (uint32_t i = 0; i < kBlocks; ++i) {
    ElasticBodyDescription block = test::describe(
        test::particle_grid(Eigen::Vector3d::Constant(side_m), side_m / 10), 1e4, 0.3, side_m / 10);
    block.object_id = i + 1;
    block.material.loss_factor = 0.1;
    block.world_from_object.position_m = {0.8 * (i % 2), 0.5, 0.8 * (i / 2)};
    if (auto added = world.add_elastic(block); !added)
      std::fprintf(stderr, "%s\n", added.error().message.c_str());
  }
  return world;
}

inline World dragged_blocks(double side_m = kSide_m) {
  World world = blocks_alone(side_m);
  const TriangleMesh box = box_mesh({0.04, 0.04, 0.04});
  for (uint32_t i = 0; i < kBoxes; ++i) {
    RigidBodyDescription body;
    body.object_id = 100 + i;
    body.mesh = box;
    body.properties = solid_mass_properties(box);
    body.material.mass_kg = 0.05;
    body.world_from_object.position_m = {-0.5 + 0.09 * (i % 10), 1.0 + 0.09 * (i / 50),
                                         -0.5 + 0.09 * (i / 10 % 5)};
    body.angular_velocity_rad_s = {3.0, 0.1 * i, 1.0};
    if (auto added = world.add_rigid(body); !added)
      std::fprintf(stderr, "%s\n", added.error().message.c_str());
  }
  return world;
}

// Replaces the boxes with four boxes of 15 cm that are broken at the start of their fall into 50 fragments of
// irregular shape, about 4 cm each. Each broken box is one object with that number of poses.
inline World blocks_and_fragments() {
  constexpr uint32_t kBroken = 4;
  constexpr size_t kFragmentsEach = kBoxes / kBroken;
  World world = blocks_alone();
  const TriangleMesh mesh = box_mesh({0.15, 0.15, 0.15});
  for (uint32_t i = 0; i < kBroken; ++i) {
    RigidBodyDescription body;
    body.object_id = 100 + i;
    body.mesh = mesh;
    body.properties = solid_mass_properties(mesh);
    body.material.mass_kg = 0.05 * kFragmentsEach;
    body.material.fragile = true;
    body.material.break_impulse_n_s = 1;
    body.world_from_object.position_m = {0.2 + 0.4 * (i % 2), 1.2, 0.2 + 0.4 * (i / 2)};
    body.angular_velocity_rad_s = {3.0, 0.1 * i, 1.0};
    BreakableOptions options;
    options.piece_count = kFragmentsEach;
    options.seed = i + 1;
    auto pieces = prepare_pieces(mesh, Fill::Solid, options);
    if (auto added = world.add_rigid(body); !added || !pieces || !world.set_pieces(body.object_id, *pieces)) {
      std::fprintf(stderr, "dragged_blocks: a breakable box could not be added\n");
      continue;
    }
    // Either of two connected pieces can be struck; a single piece does not break further.
    for (const BreakablePiece& piece : (*pieces)->pieces)
      (void)world.break_object(body.object_id, piece.mass.centre_of_mass_m);
  }
  return world;
}

inline void drag(World& world, uint64_t tick, double side_m = kSide_m) {
  const double face = side_m * side_m / (kSide_m * kSide_m);
  for (uint32_t i = 0; i < kBlocks; ++i) {
    const uint64_t jump = tick / 45 + i;
    const Eigen::Vector3d away(0.3 * std::sin(2.1 * static_cast<double>(jump)),
                               0.3 + 0.2 * std::sin(3.7 * static_cast<double>(jump)),
                               0.3 * std::cos(1.3 * static_cast<double>(jump)));
    world.set_spring(i, i + 1,
                     {{0.4 * side_m, 0.4 * side_m, 0.0},
                      Eigen::Vector3d(0.8 * (i % 2), 0.3, 0.8 * (i / 2)) + away,
                      2000.0 * face,
                      400.0 * face});
  }
}

}  // namespace livegs::bench
