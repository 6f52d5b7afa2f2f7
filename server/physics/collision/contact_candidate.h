// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs {

// A pair of close surface points, before reduction to contact manifolds.
struct ContactCandidate {
  uint64_t feature_id = 0;  // stable for the same features across substeps
  Eigen::Vector3d point_m;  // world frame
  Eigen::Vector3d normal;   // unit, world frame, from the other body towards the first
  double separation_m = 0;  // negative when overlapping
};

// Feature ids below this are points of the first body's mesh.
inline constexpr uint64_t kForeignFeature = uint64_t{1} << 32;

}  // namespace livegs
