// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs {

// The box in which coordinates are quantised, metres, world axes. See proto/frame_format.md, "Frame".
struct QuantisedBox {
  Eigen::Vector3f min_m = Eigen::Vector3f::Zero();
  Eigen::Vector3f edge_m = Eigen::Vector3f::Zero();

  // Finite, edges not negative, min + edge finite.
  bool is_valid() const;

  // Precondition: `point_m` is inside the box. 1 <= bits <= 21.
  Eigen::Matrix<uint32_t, 3, 1> quantise(const Eigen::Vector3d& point_m, int bits) const;
  Eigen::Vector3d position_m(const Eigen::Matrix<uint32_t, 3, 1>& steps, int bits) const;
};

// The smallest box of floats that contains the range from `low` to `high`. Precondition: both are finite in
// float.
QuantisedBox box_around(const Eigen::Vector3d& low, const Eigen::Vector3d& high);

}  // namespace livegs
