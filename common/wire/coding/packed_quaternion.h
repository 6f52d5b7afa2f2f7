// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

// Smallest-three encoding (proto/frame_format.md): 2 + 3 * component_bits bits; zero is exact.

namespace livegs {

inline constexpr int kPoseComponentBits = 20;      // 62 bits, error at most 0.0003 degrees
inline constexpr int kParticleComponentBits = 12;  // 38 bits, error at most 0.07 degrees

// Precondition: `rotation` is finite and not zero; it need not be exactly unit. 2 <= component_bits <= 20.
uint64_t pack_quaternion(const Eigen::Quaterniond& rotation, int component_bits);

// Any bits give a unit quaternion.
Eigen::Quaterniond unpack_quaternion(uint64_t packed, int component_bits);

}  // namespace livegs
