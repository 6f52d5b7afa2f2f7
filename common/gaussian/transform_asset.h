// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// Rotates and scales an asset about its origin: positions, kernels and the directions of colours. The scale
// is above 0. An asset that is turned back equals the original up to rounding.
void transform_asset(GaussianAsset& asset, const Eigen::Quaterniond& rotation, double scale);

}  // namespace livegs
