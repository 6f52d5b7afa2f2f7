// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "physics/collider.h"

namespace livegs {

// Convex features of a collider, which may press into a face between a body's contact points: points on the
// edges and corners of a box or the ridges of a mesh (radius 0, or half the wall thickness of a thin-wall
// collider), or the centre of a sphere (its radius).
struct ColliderFeature {
  uint64_t id;
  Eigen::Vector3d point_m;  // world frame
  double radius_m;
};

// Features within `reach_m` of `centre_m`. Points on box edges have fixed positions `spacing_m` apart, so
// their ids are stable; mesh ridges have the spacing of their construction. Planes have no features.
std::vector<ColliderFeature> collider_features(const Collider& collider, const Eigen::Vector3d& centre_m,
                                               double reach_m, double spacing_m);

}  // namespace livegs
