// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "geometry/triangle_mesh.h"

// Private to the geometry room. Intersects a closed mesh with one Voronoi cell.

namespace livegs {

// The planes that a vertex lies on identify it in all cells: at most two triangles of the mesh and the cells
// that meet there, four in all, sorted. A vertex of the mesh has only its own number; the other entries are
// ~0. Numbering: cells from 0, then triangles, then vertices.
using VertexName = std::array<uint32_t, 4>;

// A closed surface with local vertices. Its triangles are grouped in faces: the rest of a triangle of the
// mesh, or a connected polygon of a cut plane.
struct ClippedCell {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<VertexName> names;
  std::vector<std::array<uint32_t, 3>> triangles;
  struct Face {
    uint32_t label = 0;           // a neighbouring cell, or cell count + triangle number
    uint32_t begin = 0, end = 0;  // range of triangles
  };
  std::vector<Face> faces;
};

// Clips the mesh to the points at least as close to seed `cell` as to each of `neighbours`. Both cells of a
// bisector use the same formula for the side of a point. No tolerance is used: the result is closed whatever
// the rounding. Precondition: `mesh` is closed.
ClippedCell clip_to_cell(const TriangleMesh& mesh, std::span<const Eigen::Vector3d> seeds_m, uint32_t cell,
                         std::span<const uint32_t> neighbours);

}  // namespace livegs
