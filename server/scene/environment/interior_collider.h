// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "core/result.h"
#include "geometry/triangle_mesh.h"
#include "physics/collider.h"

namespace livegs {

// Builds the collider of a captured background. The solid is the region that a ball cannot reach from
// outside, so a closed room is filled at first. `stuck` returns the centres of objects inside a solid, in the
// frame of the points. For such objects the room is cut horizontally into an upper and a lower part:
// - The cut lies above one of the objects, at the height with the fewest points.
// - The parts overlap by the ball's radius. The ball can enter each part, so their union is the room with its
//   walls, floor, ceiling and furniture.
// - A cut that frees no object is discarded. At most four cuts are tried.
// `up` is a unit vector in the frame of the points.
struct InteriorCollider {
  FieldShape shape;
  TriangleMesh surface;  // of the solid: closed parts that may overlap, metres, frame of the points
};
using EmbeddedObjects = std::function<std::vector<Eigen::Vector3d>(const FieldShape&)>;
Result<InteriorCollider> interior_collider(std::span<const Eigen::Vector3d> points_m,
                                           const Eigen::Vector3d& up, const EmbeddedObjects& stuck);

}  // namespace livegs
