// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "prepare/prepare_pieces.h"
#include "scenes/rigid_fixtures.h"
#include "server/geometry/fracture/fracture_shapes.h"

// Fixtures of the fracture tests: a small fragile cup of 0.25 kg and its pieces.

namespace livegs::break_fixtures {

using namespace rigid_fixtures;
using Eigen::Vector3d;

inline constexpr double kMass_kg = 0.25;
inline constexpr double kBreakImpulse_n_s = 0.7;
inline constexpr uint32_t kCup = 1;

inline const TriangleMesh& small_cup() {
  static const TriangleMesh mesh = testing::cup_mesh(24, 4);
  return mesh;
}

inline std::shared_ptr<const BreakablePieces> pieces_of(const TriangleMesh& mesh, size_t count, uint64_t seed,
                                                        Fill fill = Fill::Solid) {
  BreakableOptions options;
  options.piece_count = count;
  options.seed = seed;
  auto pieces = prepare_pieces(mesh, fill, options);
  EXPECT_TRUE(pieces) << pieces.error().message;
  return *pieces;
}

inline const std::shared_ptr<const BreakablePieces>& cup_pieces() {
  static const std::shared_ptr<const BreakablePieces> pieces = pieces_of(small_cup(), 16, 1);
  return pieces;
}

// The cup with its bottom at `height_m`.
inline RigidBodyDescription cup_at(double height_m, double restitution = 0.2) {
  RigidBodyDescription cup = body_of(kCup, small_cup(), kMass_kg);
  cup.material.fragile = true;
  cup.material.break_impulse_n_s = kBreakImpulse_n_s;
  cup.material.restitution = restitution;
  cup.world_from_object.position_m.y() = height_m;
  return cup;
}

inline World with_cup(const RigidBodyDescription& cup, World world,
                      const std::shared_ptr<const BreakablePieces>& pieces = cup_pieces()) {
  EXPECT_TRUE(world.add_rigid(cup));
  const auto set = world.set_pieces(kCup, pieces);
  EXPECT_TRUE(set) << set.error().message;
  return world;
}

inline double mass_of(const World& world, uint32_t id) {
  double sum = 0;
  for (const BodyState& body : world.bodies()) sum += body.object_id == id ? body.mass_kg : 0.0;
  return sum;
}

inline size_t body_count(const World& world, uint32_t id) {
  size_t count = 0;
  for (const BodyState& body : world.bodies()) count += body.object_id == id;
  return count;
}

}  // namespace livegs::break_fixtures
