// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "geometry/triangle_mesh.h"

namespace livegs {

// Shape descriptors of a body. Scores are 0 … 1 and independent of size and orientation. The openness depends
// slightly on orientation, because its rays are fixed in the object frame.
struct MeshFacts {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  // edges of the bounding box along the object's axes
  Eigen::Vector3d box_m = Eigen::Vector3d::Zero();   // smallest box of any orientation, longest first
  // Solid box with the same moments, longest first.
  Eigen::Vector3d principal_size_m = Eigen::Vector3d::Zero();
  double volume_m3 = 0.0;  // enclosed
  double area_m2 = 0.0;
  double mean_wall_m = 0.0;     // 2 V / A: the thickness of a sheet, a third of a ball's diameter
  double hull_volume_m3 = 0.0;  // volume of the convex hull
  double solidity = 0.0;        // volume / hull volume, 1 for a convex body
  // Volume of visible cavities relative to that volume plus the body: cups, bowls, bags.
  double openness = 0.0;
  int piece_count = 0;      // parts of the surface that share no vertex
  double thin_sheet = 0.0;  // 0 up to a brick, 1 from a thickness of a 50th of the width; flat or bent
  double rod = 0.0;         // 0 up to a length of 2.5 widths, 1 from 10 widths; straight or slightly bent
};

// Precondition: a closed mesh with positive volume. Deterministic.
MeshFacts mesh_facts(const TriangleMesh& mesh);

}  // namespace livegs
