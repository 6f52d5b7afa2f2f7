// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Returns the convex hull, triangulated, outward-facing; empty if the points lie in one plane. Exact
// predicates. Precondition: finite values.
TriangleMesh convex_hull(std::span<const Eigen::Vector3d> points_m);

}  // namespace livegs
