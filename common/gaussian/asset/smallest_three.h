// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>

namespace livegs {

inline constexpr float kSqrtHalf = 0.70710678118654752f;

// Rebuilds a unit quaternion from all components but its largest, which is positive and follows from the unit
// length. Components are in the order of the format; `others` are in ascending order of index.
inline Eigen::Vector4f from_smallest_three(unsigned largest, const std::array<float, 3>& others) {
  Eigen::Vector4f q;
  float squares = 0;
  for (unsigned i = 0, next = 0; i < 4; ++i) {
    if (i == largest) continue;
    q[i] = others[next++];
    squares += q[i] * q[i];
  }
  q[largest] = std::sqrt(std::max(0.0f, 1.0f - squares));
  return q;
}

// The reverse: number of the largest component and the others in ascending order, with the sign that makes
// the largest positive. `q` is unit, in the order of the format.
struct SmallestThree {
  unsigned largest = 0;
  std::array<float, 3> others = {};
};

inline SmallestThree to_smallest_three(const Eigen::Vector4f& q) {
  SmallestThree packed;
  q.cwiseAbs().maxCoeff(&packed.largest);
  const float sign = q[packed.largest] < 0 ? -1.0f : 1.0f;
  for (unsigned i = 0, next = 0; i < 4; ++i) {
    if (i != packed.largest) packed.others[next++] = sign * q[i];
  }
  return packed;
}

}  // namespace livegs
