// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/triangle_mesh.h"

// Convex polyhedron: boxes, wedges, tiles, fragments. Its distances and contacts are exact, whereas a grid
// rounds edges.

namespace livegs {

struct ContactCandidate;

// Size limits. Larger: separating axis tests cost more than sampling points.
inline constexpr size_t kMaxPolyhedronVertices = 64;
inline constexpr size_t kMaxPolyhedronFaces = 48;

struct ConvexPolyhedron {
  struct Face {
    Eigen::Vector3d normal;  // unit, outwards
    double offset_m;         // normal.dot(p) for p in the plane
    uint16_t first, count;   // range in `loops`, counter-clockwise seen from outside
  };
  struct Edge {
    uint16_t from, to;     // vertices
    uint16_t left, right;  // faces; from -> to is counter-clockwise in the left face
  };
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<Face> faces;
  std::vector<uint16_t> loops;
  std::vector<Edge> edges;
  Eigen::Vector3d centre_m;     // mean of the vertices, inside
  double inner_radius_m = 0.0;  // radius of the largest inscribed ball about centre_m

  struct Sample {
    double distance_m;  // negative inside
    // Unit. Outside: from the nearest surface point to the sample. Inside: normal of the nearest face.
    Eigen::Vector3d normal;
  };
  // Exact outside and inside.
  Sample sample(const Eigen::Vector3d& point_m) const;
  const Eigen::Vector3d& loop_vertex(const Face& face, int index) const {
    return vertices_m[loops[face.first + index]];
  }
};

// Convex polyhedron of a closed mesh, with coplanar triangles merged to faces. nullopt if the mesh is not
// convex within 1e-5 of its size, is not closed, or exceeds the limits above.
std::optional<ConvexPolyhedron> convex_polyhedron(const TriangleMesh& mesh);
// Precondition: positive edge lengths.
ConvexPolyhedron box_polyhedron(const Eigen::Vector3d& size_m);

// Contact of two polyhedra (polyhedron_manifold.cpp). Pure functions.

struct PlacedPolyhedron {
  const ConvexPolyhedron* shape;
  Eigen::Matrix3d rotation;    // world from body
  Eigen::Vector3d position_m;  // world position of the body's origin
};

// Largest gap over the separating axes (face normals of both, cross products of edges). Negative: minus the
// penetration depth. Positive: a lower bound of the distance. Stops at the first gap above `reach_m`.
double polyhedron_gap_m(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m);

// Contacts within `reach_m` along the axis of least overlap; normals point from b to a. Face on face yields
// the corners of the clipped overlap (points of the incident body), edge on edge yields one point. A face is
// preferred to an edge, and a face of a to one of b, unless the other is better by more than `tolerance_m`.
// Ids encode faces, edges and corners; ids of a's own points are below kForeignFeature.
void polyhedron_contacts(const PlacedPolyhedron& a, const PlacedPolyhedron& b, double reach_m,
                         double tolerance_m, std::vector<ContactCandidate>& candidates);

}  // namespace livegs
