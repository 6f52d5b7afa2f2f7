// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// In a closed manifold, exactly two triangles share each edge, in opposite directions, and the triangles
// around each vertex form one fan.
struct MeshTopology {
  bool closed = false;           // each edge occurs equally often in both directions
  bool manifold = false;         // closed, two triangles per edge, one fan per vertex
  int euler_characteristic = 0;  // V - E + F over used vertices: 2 per sphere, 0 per torus
  int piece_count = 0;
};
MeshTopology mesh_topology(const TriangleMesh& mesh);

// Returns the number of each triangle's piece. Pieces are joined by shared vertices and numbered from 0 by
// their first triangle.
std::vector<int> mesh_pieces(const TriangleMesh& mesh);

// Returns the enclosed volume, positive for outward-facing triangles (divergence theorem).
double signed_volume_m3(const TriangleMesh& mesh);

Eigen::AlignedBox3d mesh_bounds_m(const TriangleMesh& mesh);

}  // namespace livegs
