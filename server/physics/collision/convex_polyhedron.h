// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/triangle_mesh.h"

// A convex body with flat faces: boxes, wedges, tiles, fragments. Its distance and its contacts are exact,
// where a grid would round its edges.

namespace livegs {

// More faces, edges or vertices than this and testing them all costs more than sampling points.
inline constexpr size_t kMaxPolyhedronVertices = 64;
inline constexpr size_t kMaxPolyhedronFaces = 48;

struct ConvexPolyhedron {
  struct Face {
    Eigen::Vector3d normal;  // unit, outwards
    double offset_m;         // normal.dot(p) of the plane
    uint16_t first, count;   // in `loops`, counter-clockwise seen from outside
  };
  struct Edge {
    uint16_t from, to;     // vertices
    uint16_t left, right;  // faces; from -> to is counter-clockwise in the left one
  };
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Face> faces;
  std::vector<uint16_t> loops;
  std::vector<Edge> edges;
  Eigen::Vector3d centre_m;     // mean of the vertices: inside
  double inner_radius_m = 0.0;  // of the largest ball about centre_m that fits in

  struct Sample {
    double distance_m;       // negative inside
    Eigen::Vector3d normal;  // unit, from the nearest point of the surface to the point, or its face's
  };
  // Exact for points outside and inside.
  Sample sample(const Eigen::Vector3d& point_m) const;
  const Eigen::Vector3d& loop_vertex(const Face& face, int index) const {
    return vertices_m[loops[face.first + index]];
  }
};

// The polyhedron a closed mesh is, triangles in one plane joined to faces; nothing if the mesh is not convex
// to 1e-5 of its size, is not closed or is beyond the limits above.
std::optional<ConvexPolyhedron> convex_polyhedron(const TriangleMesh& mesh);
// Precondition: positive edge lengths.
ConvexPolyhedron box_polyhedron(const Eigen::Vector3d& size_m);

}  // namespace livegs
