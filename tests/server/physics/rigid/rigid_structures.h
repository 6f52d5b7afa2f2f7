// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "geometry/mesh/convex_hull.h"
#include "scenes/rigid_fixtures.h"

// Structures of boxes and wedges that must stay standing, each on its own floor.

namespace livegs::rigid_fixtures {

inline void add_box(World& world, uint32_t id, const Eigen::Vector3d& size_m, double mass_kg,
                    const Pose& pose, double friction) {
  auto box = box_body(id, size_m, mass_kg);
  box.material.friction = friction;
  box.world_from_object = pose;
  EXPECT_TRUE(world.add_rigid(box));
}

inline Pose at(double x, double y, double z = 0.0, double lean_rad = 0.0) {
  return {{x, y, z}, Eigen::Quaterniond(Eigen::AngleAxisd(-lean_rad, Eigen::Vector3d::UnitZ()))};
}

// A stack of cubes, ids from 1 at the bottom.
inline void add_stack(World& world, uint32_t count, double size_m, double mass_kg) {
  world.add_collider(floor_plane(0.6));
  for (uint32_t i = 0; i < count; ++i) {
    add_box(world, i + 1, Eigen::Vector3d::Constant(size_m), mass_kg, at(0, (0.5 + i) * size_m), 0.6);
  }
}

// A half circle of nine wedges with radii of 0.35 and 0.5 m, ids from 1 at one foot.
inline void add_arch(World& world) {
  constexpr int kWedges = 9;
  constexpr double kInner = 0.35, kOuter = 0.5, kDepth = 0.2;
  world.add_collider(floor_plane(0.8));
  for (int i = 0; i < kWedges; ++i) {
    std::vector<Eigen::Vector3d> corners;
    for (const int end : {i, i + 1}) {
      const double angle = M_PI * end / kWedges;
      for (const double radius : {kInner, kOuter}) {
        for (const double z : {-0.5 * kDepth, 0.5 * kDepth}) {
          corners.push_back({radius * std::cos(angle), radius * std::sin(angle), z});
        }
      }
    }
    auto wedge = body_of(static_cast<uint32_t>(i + 1), convex_hull(corners), 5.0);
    wedge.material.friction = 0.8;
    EXPECT_TRUE(world.add_rigid(wedge));
  }
}

// Three floors of leaning cards with flat ones between: 15 cards of 2 g, ids from 1 at the ground.
inline void add_card_house(World& world) {
  constexpr double kLength = 0.1, kThick = 0.002, kWidth = 0.06, kMass = 0.002, kFriction = 0.7;
  const double lean = radians(25);
  const double high = kLength * std::cos(lean) + kThick * std::sin(lean);  // height of one floor of cards
  const double side = 0.5 * (kThick * std::cos(lean) + kLength * std::sin(lean));
  const double span = 4.0 * side + 0.001;
  world.add_collider(floor_plane(kFriction));
  uint32_t id = 1;
  for (int floor = 0; floor < 3; ++floor) {
    const double foot = floor * (high + kThick);
    for (int i = 0; i < 3 - floor; ++i) {
      const double x = (i - 0.5 * (2 - floor)) * span;
      add_box(world, id++, {kThick, kLength, kWidth}, kMass, at(x - side, foot + 0.5 * high, 0, lean),
              kFriction);
      add_box(world, id++, {kThick, kLength, kWidth}, kMass, at(x + side, foot + 0.5 * high, 0, -lean),
              kFriction);
    }
    for (int i = 0; i < 2 - floor; ++i) {
      const double x = (i - 0.5 * (1 - floor)) * span;
      add_box(world, id++, {span - 0.0005, kThick, kWidth}, kMass, at(x, foot + high + 0.5 * kThick),
              kFriction);
    }
  }
}

}  // namespace livegs::rigid_fixtures
