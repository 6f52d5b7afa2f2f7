// SPDX-License-Identifier: Apache-2.0
#include "gaussian/asset/morton_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace livegs {
namespace {

constexpr double kCells = 2097151;  // 2^21 - 1

// Moves bit i of a 21-bit number to bit 3 i.
uint64_t spread_bits(uint64_t x) {
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  return (x | x << 2) & 0x1249249249249249;
}

}  // namespace

std::vector<uint32_t> morton_order(const GaussianAsset& asset) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (const Eigen::Vector3f& position : asset.positions) {
    low = low.cwiseMin(position.cast<double>());
    high = high.cwiseMax(position.cast<double>());
  }
  std::vector<uint64_t> codes(asset.size());
  for (size_t i = 0; i < asset.size(); ++i) {
    codes[i] = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double side = high[axis] - low[axis];
      const double share = side > 0 ? (static_cast<double>(asset.positions[i][axis]) - low[axis]) / side : 0;
      codes[i] |= spread_bits(static_cast<uint64_t>(share * kCells)) << axis;
    }
  }
  std::vector<uint32_t> order(asset.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return codes[a] < codes[b]; });
  return order;
}

}  // namespace livegs
