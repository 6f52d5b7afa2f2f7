// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

namespace livegs {

// What the shape of a body says about what it is. Scores lie in 0 … 1 and do not depend on size or
// orientation (openness a little: its rays are fixed in the object frame).
struct MeshFacts {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // edges of the bounding box along the object's axes
  Eigen::Vector3d box_m =
      Eigen::Vector3d::Zero();  // of the smallest box around it however it lies, longest first
  Eigen::Vector3d principal_size_m =
      Eigen::Vector3d::Zero();  // of the solid box with the same moments, longest first
  double volume_m3 = 0.0;       // enclosed
  double area_m2 = 0.0;
  double mean_wall_m = 0.0;     // 2 V / A: the thickness of a sheet, a third of a ball's diameter
  double hull_volume_m3 = 0.0;  // of the convex hull
  double solidity = 0.0;        // volume / hull volume, 1 for a convex body
  double openness =
      0.0;              // room inside that can be seen into, as a part of it and the body: cups, bowls, bags
  int piece_count = 0;  // parts of the surface that share no vertex
  double thin_sheet = 0.0;  // 0 up to a brick, 1 from a 50th as thick as wide; flat or bent
  double rod = 0.0;         // 0 up to 2.5 times as long as wide, 1 from 10 times; straight or slightly bent
};

// Precondition: a closed mesh with positive volume. Deterministic.
MeshFacts mesh_facts(const TriangleMesh& mesh);

}  // namespace livegs
