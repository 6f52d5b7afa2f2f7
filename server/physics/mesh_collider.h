// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/triangle_mesh.h"
#include "physics/collider.h"
#include "physics/point_tree.h"

namespace livegs {

// Where a mesh sticks out: points along its convex edges, corners included, that may press into a face between the points
// of what lies on them. In the mesh's frame.
struct RidgePoints {
  std::vector<Eigen::Vector3d> points_m;
  PointTree tree;  // of points_m
};
// Along edges that turn by more than 30 degrees and those of one triangle only, at most `spacing_m` apart.
RidgePoints ridge_points(const TriangleMesh& mesh, double spacing_m);

// A mesh as a collider: a distance field of 64 cells along the longest side, exact where the mesh is thin, and its ridges
// at half a cell. Precondition: at least one triangle; closed.
FieldShape mesh_collider(const TriangleMesh& mesh);

}  // namespace livegs
