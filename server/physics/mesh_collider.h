// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/triangle_mesh.h"
#include "physics/collider.h"
#include "physics/collision/bounding_sphere_tree.h"

namespace livegs {

// Where a mesh sticks out: points along its convex edges, corners included, that may press into a face
// between the points of what lies on them. In the mesh's frame.
struct RidgePoints {
  std::vector<Eigen::Vector3d> points_m;
  BoundingSphereTree tree;  // of points_m
};
// Along edges that turn by more than 30 degrees and those of one triangle only, at most `spacing_m` apart. A
// groove is a ridge from behind, where there is a behind.
enum class ConcaveEdges { Skip, Include };
RidgePoints ridge_points(const TriangleMesh& mesh, double spacing_m,
                         ConcaveEdges concave_edges = ConcaveEdges::Skip);

// Both: a distance field of 64 cells along the longest side, and ridges at half a cell. Precondition: a
// triangle with an area.

// A closed mesh as a collider, exact where it is thin. Parts of it that are inside out are turned over; those
// that face inwards within another are its hollows.
FieldShape mesh_collider(const TriangleMesh& mesh);

// A mesh as a wall about its surface, solid for half its thickness on either side: of what is not closed
// nobody can tell the inside, and of a room it is the inside that counts. Which way its triangles face makes
// no difference.
FieldShape wall_collider(const TriangleMesh& mesh);
// 4 mm, or a 64th of the length where that is less: thinner, and what is thrown at it gets through; thicker,
// and what lies on it hovers.
double wall_thickness_m(double longest_m);

}  // namespace livegs
