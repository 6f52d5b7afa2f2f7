// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// xx, xy, xz, yy, yz, zz of a symmetric matrix.
using Symmetric3f = std::array<float, 6>;

// Current poses of the kernels of one asset, in the world frame, metres. Skinning writes them, drawing reads
// them. Opacity and colour stay in the asset. All arrays have its length.
struct PosedKernels {
  std::vector<Eigen::Vector3f> positions_m;
  std::vector<Symmetric3f> covariances_m2;
  // rotation only; SH are evaluated at its inverse times the view direction
  std::vector<Eigen::Quaternionf> world_from_asset;

  void resize(size_t count) {
    positions_m.resize(count);
    covariances_m2.resize(count);
    world_from_asset.resize(count);
  }
};

// One object to draw. Both pointers must stay valid during the call.
struct DrawnObject {
  const GaussianAsset* asset = nullptr;
  const PosedKernels* kernels = nullptr;
  uint32_t object_id = 0;
};

}  // namespace livegs
