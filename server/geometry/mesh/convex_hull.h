// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/triangle_mesh.h"

namespace livegs {

// The convex hull, triangulated, outwards; empty when the points lie in one plane. Exact predicates.
// Precondition: all values finite.
TriangleMesh convex_hull(std::span<const Eigen::Vector3d> points_m);

}  // namespace livegs
