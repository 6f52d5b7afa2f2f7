// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/fracture/voronoi_pieces.h"

// Inside the room: flat kernels that cover the faces of the cuts, so that a broken body is not hollow.

namespace livegs {

struct FaceKernel {
  Eigen::Vector3d position_m;
  Eigen::Matrix3d axes;          // columns: two in the face, the third its normal out of the piece
  Eigen::Vector3d deviations_m;  // standard deviations along them
  uint32_t piece = 0;
  uint32_t bond = 0;
};

// Both sides of every bond, about spacing_m apart: a hexagonal grid, and rows along the rim whose kernels are
// narrow across it: at the rim a kernel's opacity is down to a seventh, and at three deviations it reaches no
// farther beyond than max_overhang_m. They lie within their piece, three deviations behind its face. In order
// of bonds, the first piece's side before the second's; the same places on both.
std::vector<FaceKernel> face_kernels(const VoronoiPieces& pieces, double spacing_m, double max_overhang_m);

}  // namespace livegs
