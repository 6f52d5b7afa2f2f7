// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Returns the edges of a small box of any orientation around a convex mesh, longest first, metres. It is the
// smallest box with a side along one of the mesh's largest faces or a coordinate axis. The true minimum
// touches with a face or three edges (O'Rourke 1985): the result is exact for objects with a flat side and
// within a few per cent for round ones. Deterministic. Precondition: closed and convex, as returned by
// convex_hull.
Eigen::Vector3d smallest_box_m(const TriangleMesh& hull);

}  // namespace livegs
