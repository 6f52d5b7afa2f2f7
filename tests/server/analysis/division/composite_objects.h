// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "core/pose.h"
#include "gaussian/gaussian_asset.h"

namespace livegs {

// An object of several materials, made of simple solids, with the true part of each kernel.
struct CompositeObject {
  std::string name;
  GaussianAsset asset;
  std::vector<uint16_t> part;  // of each kernel: index in the parts of its row of objects.csv
  Similarity object_from_asset;
  // Centre of mass by the densities of its solids, which are not those of the tables; object frame, metres.
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();
};

// Eight objects with the parts of their rows: hammer, axe, screwdriver, shovel, lamp, potted plant, broom and
// kitchen knife. Tools lie aslant, as captured; the lamp and the plant stand.
std::vector<CompositeObject> composite_objects();

}  // namespace livegs
