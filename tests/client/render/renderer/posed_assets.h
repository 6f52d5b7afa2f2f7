// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"

// Assets as a scene shows them, for tests and benchmarks of pictures.

namespace livegs {

// -Y turned up, the diagonal of the bounding box 1.5 m, its middle at the origin. twist_rad_m > 0: deformed
// as well, by a twist of that angle a metre about the upright and a stretch of 1.2 along it, as skinning does
// it: covariance F S Fᵀ.
PosedKernels pose_asset(const GaussianAsset& asset, double twist_rad_m = 0.0);

// Where the kernels of the 5th to the 95th percentile along each axis are: the camera goes by these, not by
// floaters.
struct CloudExtent {
  Eigen::Vector3d centre_m;
  double size_m = 0;  // of the diagonal
};
CloudExtent extent_of(const PosedKernels& kernels);

// From before the cloud at 1.3 times its size, near at 0.6, and from its very middle with a wide lens.
enum class View { Front, Close, Inside };
const char* name_of(View view);
Camera view_of(const CloudExtent& extent, View view, int width, int height);

}  // namespace livegs
