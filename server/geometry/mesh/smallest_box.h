// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Edges of a small box around a convex mesh, longest first, metres, whichever way it lies: of all boxes that
// have one of the mesh's largest faces in a side (or a coordinate axis across it), the smallest. The smallest
// box of all touches with a face or three edges (O'Rourke 1985); for things with a flat side this is it, for
// round ones within a few percent. Deterministic. Precondition: closed and convex, as convex_hull makes it.
Eigen::Vector3d smallest_box_m(const TriangleMesh& hull);

}  // namespace livegs
