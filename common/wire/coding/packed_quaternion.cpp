// SPDX-License-Identifier: Apache-2.0
#include "wire/coding/packed_quaternion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace livegs {

uint64_t pack_quaternion(const Eigen::Quaterniond& rotation, int component_bits) {
  const Eigen::Vector4d v = rotation.normalized().coeffs();  // x, y, z, w
  int largest = 3;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(v[i]) > std::abs(v[largest])) largest = i;
  }
  const double sign = v[largest] < 0.0 ? -1.0 : 1.0;
  const int64_t zero = int64_t{1} << (component_bits - 1);
  const double scale = std::numbers::sqrt2 * static_cast<double>(zero - 1);
  uint64_t packed = static_cast<uint64_t>(largest) << (3 * component_bits);
  int shift = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == largest) continue;
    const int64_t q = std::clamp<int64_t>(std::llround(sign * v[i] * scale), 1 - zero, zero - 1) + zero;
    packed |= static_cast<uint64_t>(q) << shift;
    shift += component_bits;
  }
  return packed;
}

Eigen::Quaterniond unpack_quaternion(uint64_t packed, int component_bits) {
  const int largest = static_cast<int>((packed >> (3 * component_bits)) & 3u);
  const int64_t zero = int64_t{1} << (component_bits - 1);
  const double scale = std::numbers::sqrt2 * static_cast<double>(zero - 1);
  const uint64_t mask = (uint64_t{1} << component_bits) - 1;
  Eigen::Vector4d v = Eigen::Vector4d::Zero();
  int shift = 0;
  for (int i = 0; i < 4; ++i) {
    if (i == largest) continue;
    v[i] = static_cast<double>(static_cast<int64_t>((packed >> shift) & mask) - zero) / scale;
    shift += component_bits;
  }
  v[largest] = std::sqrt(std::max(0.0, 1.0 - v.squaredNorm()));
  return Eigen::Quaterniond(v).normalized();
}

}  // namespace livegs
