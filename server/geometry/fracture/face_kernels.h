// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"

// Private to the geometry room. Flat kernels that cover the cut faces, so that a broken body does not look
// hollow.

namespace livegs {

struct FaceKernel {
  Eigen::Vector3d position_m;
  Eigen::Matrix3d axes;          // columns: two in the face, the third is the outward normal of the piece
  Eigen::Vector3d deviations_m;  // standard deviations along the axes, metres
  uint32_t piece = 0;
  uint32_t bond = 0;
};

// Makes kernels for both sides of each bond, about spacing_m apart: a hexagonal grid, and rows along the rim
// with narrow kernels. At the rim a kernel's opacity is at most a seventh. At three standard deviations it
// extends at most max_overhang_m beyond the rim. Kernels lie inside their piece, three deviations behind the
// face. Sorted by bond, first piece before second; both sides use the same positions.
std::vector<FaceKernel> face_kernels(const VoronoiPieces& pieces, double spacing_m, double max_overhang_m);

}  // namespace livegs
