// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Each edge of a closed manifold is shared by exactly two triangles that run along it in opposite directions,
// and the triangles round each vertex form one fan.
struct MeshTopology {
  bool closed = false;           // every edge has as many triangles one way as the other
  bool manifold = false;         // closed, two triangles an edge, one fan a vertex
  int euler_characteristic = 0;  // V - E + F over vertices in use: 2 a sphere-like piece, 0 a torus-like one
  int piece_count = 0;
};
MeshTopology mesh_topology(const TriangleMesh& mesh);

// For each triangle the number of its piece (joined by shared vertices), numbered from 0 in order of first
// triangle.
std::vector<int> mesh_pieces(const TriangleMesh& mesh);

// Enclosed volume, positive when triangles face outwards (divergence theorem).
double signed_volume_m3(const TriangleMesh& mesh);

Eigen::AlignedBox3d mesh_bounds_m(const TriangleMesh& mesh);

}  // namespace livegs
