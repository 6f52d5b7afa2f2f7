// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Vertices at exactly the same place become one, in order of first use; triangles that collapse are left out.
TriangleMesh weld_vertices(const TriangleMesh& mesh);

// Edges with more triangles one way than the other: 0 for a closed mesh.
size_t open_edge_count(const TriangleMesh& mesh);

}  // namespace livegs
