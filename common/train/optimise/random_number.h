// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace livegs {

// Random numbers by position instead of order: the same (seed, stream, index) gives the same number on any
// thread and after a resume. SplitMix64 (Steele et al. 2014).
inline uint64_t mixed_bits(uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}
inline uint64_t random_bits(uint64_t seed, uint64_t stream, uint64_t index) {
  return mixed_bits(mixed_bits(mixed_bits(seed) ^ stream) ^ index);
}
// In [0, 1).
inline double random_share(uint64_t seed, uint64_t stream, uint64_t index) {
  return static_cast<double>(random_bits(seed, stream, index) >> 11) * 0x1p-53;
}
// Two independent normal numbers (Box and Muller 1958).
inline void random_normals(uint64_t seed, uint64_t stream, uint64_t index, float& a, float& b) {
  const uint64_t bits = random_bits(seed, stream, index);
  const float radius = std::sqrt(-2.0f * std::log((static_cast<float>(bits >> 40) + 1.0f) * 0x1p-24f));
  const float angle = 2.0f * std::numbers::pi_v<float> * static_cast<float>(bits & 0xffffff) * 0x1p-24f;
  a = radius * std::cos(angle);
  b = radius * std::sin(angle);
}

}  // namespace livegs
