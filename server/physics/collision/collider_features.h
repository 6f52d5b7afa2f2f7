// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "physics/collider.h"

namespace livegs {

// What sticks out of a collider and may press into a body's face between the body's own contact points:
// points of a box's edges and corners or a mesh's ridges (radius 0; half its thickness on a wall about a
// surface), a sphere's centre (its radius).
struct ColliderFeature {
  uint64_t id;
  Eigen::Vector3d point_m;  // world
  double radius_m;
};

// Those within `reach_m` of `centre_m`. Edge points stand at fixed places of the edge, `spacing_m` apart, so
// that their ids last; those of a mesh are as far apart as it was made with. Planes have none.
std::vector<ColliderFeature> collider_features(const Collider& collider, const Eigen::Vector3d& centre_m,
                                               double reach_m, double spacing_m);

}  // namespace livegs
