// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Merges vertices at exactly the same position, in order of first use, and removes triangles that collapse.
TriangleMesh weld_vertices(const TriangleMesh& mesh);

// Returns the number of edges that do not occur equally often in both directions: 0 for a closed mesh.
size_t open_edge_count(const TriangleMesh& mesh);

}  // namespace livegs
