// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs {

// A place where two surfaces are close, before manifolds are made of them.
struct ContactCandidate {
  uint64_t feature_id = 0;  // the same place in the next substep has the same id
  Eigen::Vector3d point_m;  // world
  Eigen::Vector3d normal;   // unit, world, from the other towards the first body
  double separation_m = 0;  // negative when overlapping
};

// Features below this are points of the first body's mesh.
inline constexpr uint64_t kForeignFeature = uint64_t{1} << 32;

}  // namespace livegs
