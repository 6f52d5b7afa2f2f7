// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"

// Posed assets for tests and benchmarks of pictures.

namespace livegs {

// -Y is turned up, the bounding box has a diagonal of 1.5 m and its centre at the origin. twist_rad_m > 0
// also deforms the asset, by a twist of that angle per metre around the vertical and a vertical stretch of
// 1.2, as skinning does: covariance F S Fᵀ.
PosedKernels pose_asset(const GaussianAsset& asset, double twist_rad_m = 0.0);

// Extent of the kernels from the 5th to the 95th percentile along each axis; it excludes floaters.
struct CloudExtent {
  Eigen::Vector3d centre_m;
  double size_m = 0;  // length of the diagonal
};
CloudExtent extent_of(const PosedKernels& kernels);

// From the front at 1.3 times the extent's size, close at 0.6, and from its centre with a wide lens.
enum class View { Front, Close, Inside };
const char* name_of(View view);
Camera view_of(const CloudExtent& extent, View view, int width, int height);

}  // namespace livegs
