// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/triangle_mesh.h"
#include "physics/collider.h"
#include "physics/collision/bounding_sphere_tree.h"

namespace livegs {

// Points along a mesh's convex edges, corners included, in the mesh's frame. They are tested against bodies
// because an edge may press into a face between the body's contact points.
struct RidgePoints {
  std::vector<Eigen::Vector3d> points_m;
  BoundingSphereTree tree;  // of points_m
};
// Samples edges with a dihedral angle of more than 30 degrees and boundary edges, at most `spacing_m` apart.
// Concave edges are included for open surfaces, where the other side sees them as ridges.
enum class ConcaveEdges { Skip, Include };
RidgePoints ridge_points(const TriangleMesh& mesh, double spacing_m,
                         ConcaveEdges concave_edges = ConcaveEdges::Skip);

// Both colliders have a distance field of 64 cells along the longest side and ridge points half a cell apart.
// Precondition: at least one triangle has an area.

// Solid collider of a closed mesh, exact at thin walls. Inside-out parts are flipped; parts that face inwards
// inside another part are cavities.
FieldShape mesh_collider(const TriangleMesh& mesh);

// Thin-wall collider of an open mesh (or a room): solid within half the wall thickness on either side of the
// surface. The orientation of the triangles is ignored.
FieldShape wall_collider(const TriangleMesh& mesh);
// Wall thickness, m: 4 mm, or 1/64 of the longest side if that is less. Thinner: fast objects tunnel.
// Thicker: resting objects hover visibly.
double wall_thickness_m(double longest_m);

}  // namespace livegs
