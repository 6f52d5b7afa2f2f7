// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.h"

// Inside the room: a closed mesh intersected with one Voronoi cell.

namespace livegs {

// The planes a vertex lies on, which name it whichever cell it was found from: up to two triangles of the
// mesh and the cells that meet there, four in all, sorted; a vertex of the mesh itself has its own number
// alone, rest ~0. Numbers: cells from 0, then triangles, then vertices.
using VertexName = std::array<uint32_t, 4>;

// A closed surface over local vertices. Its triangles come in faces: what is left of one triangle of the
// mesh, or one connected polygon of a cut plane.
struct ClippedCell {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<VertexName> names;
  std::vector<std::array<uint32_t, 3>> triangles;
  struct Face {
    uint32_t label = 0;           // a neighbouring cell, or cell count + number of the triangle
    uint32_t begin = 0, end = 0;  // triangles
  };
  std::vector<Face> faces;
};

// Keeps what is at least as near to seed `cell` as to each of `neighbours`. On which side of a bisector a
// point lies is decided by one formula for both its cells. No tolerance is used: the result is closed
// whatever the rounding. Precondition: `mesh` is closed.
ClippedCell clip_to_cell(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m, uint32_t cell,
                         std::span<const uint32_t> neighbours);

}  // namespace livegs
