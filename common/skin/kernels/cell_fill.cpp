// SPDX-License-Identifier: Apache-2.0
#include "skin/kernels/cell_fill.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace livegs {
namespace {

// Minimum overlap of a box with a part, in parts. A smaller overlap does not count as contact.
constexpr float kMinOverlap = 1e-3f;

}  // namespace

uint64_t fill_of_box(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  std::array<int, 3> first, last;
  for (int d = 0; d < 3; ++d) {
    const float from = kFillParts * low[d] + kMinOverlap, to = kFillParts * high[d] - kMinOverlap;
    const float middle = 0.5f * (from + to);
    first[d] = std::clamp(static_cast<int>(std::floor(std::min(from, middle))), 0, kFillParts - 1);
    last[d] = std::clamp(static_cast<int>(std::floor(std::max(to, middle))), first[d], kFillParts - 1);
  }
  uint64_t fill = 0;
  for (int z = first[2]; z <= last[2]; ++z) {
    for (int y = first[1]; y <= last[1]; ++y) {
      for (int x = first[0]; x <= last[0]; ++x)
        fill |= uint64_t{1} << (x + kFillParts * (y + kFillParts * z));
    }
  }
  return fill;
}

FillDistance fill_distance(uint64_t fill, const Eigen::Vector3f& point) {
  if (fill == 0) fill = kFullCell;
  // Squared distance to each of the four parts along each axis.
  std::array<std::array<float, kFillParts>, 3> along;
  FillDistance distance;
  for (int d = 0; d < 3; ++d) {
    for (int part = 0; part < kFillParts; ++part) {
      const float from_middle = std::abs(kFillParts * point[d] - (static_cast<float>(part) + 0.5f));
      const float outside = std::max(0.0f, from_middle - 0.5f) / kFillParts;
      along[d][part] = outside * outside;
    }
    const float outside = std::max(0.0f, std::abs(point[d] - 0.5f) - 0.5f);
    distance.to_cell += outside * outside;
  }
  distance.to_material = INFINITY;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float count = 0.0f;
  for (int bit = 0; bit < 64; ++bit) {
    if ((fill >> bit & 1) == 0) continue;
    const int x = bit % kFillParts, y = bit / kFillParts % kFillParts, z = bit / (kFillParts * kFillParts);
    distance.to_material = std::min(distance.to_material, along[0][x] + along[1][y] + along[2][z]);
    sum += Eigen::Vector3i(x, y, z).cast<float>();
    count += 1.0f;
  }
  const Eigen::Vector3f middle = (sum / count + Eigen::Vector3f::Constant(0.5f)) / kFillParts;
  distance.to_middle = (point - middle).squaredNorm();
  return distance;
}

}  // namespace livegs
