// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#ifdef __AVX__
#include <immintrin.h>
#endif

// Eight floats in compiler vector types: AVX2 if the target has it, scalar code otherwise.

namespace livegs {

using Lanes = float __attribute__((vector_size(32)));
using LaneMask = int32_t __attribute__((vector_size(32)));  // all bits of a lane, or none

inline Lanes lanes(float value) { return Lanes{} + value; }
inline Lanes lane_indices() { return Lanes{0, 1, 2, 3, 4, 5, 6, 7}; }

inline Lanes& lanes_at(float* aligned) { return *reinterpret_cast<Lanes*>(aligned); }

inline Lanes min(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes max(Lanes a, Lanes b) { return a > b ? a : b; }

// Bit i is set if lane i is set.
inline uint32_t mask_bits(LaneMask mask) {
#ifdef __AVX__
  return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
  uint32_t bits = 0;
  for (int i = 0; i < 8; ++i) bits |= (mask[i] & 1u) << i;
  return bits;
#endif
}

inline Lanes sqrt(Lanes x) {
#ifdef __AVX__
  return _mm256_sqrt_ps(x);
#else
  for (int i = 0; i < 8; ++i) x[i] = __builtin_sqrtf(x[i]);
  return x;
#endif
}

// 2^x for -126 <= x <= 126, relative error below 4e-7. x is split into the nearest integer, which becomes the
// exponent, and a fraction in [-0.5, 0.5]. The polynomial interpolates 2^f at the six Chebyshev nodes (error
// 1.6e-7); the rest is rounding.
inline Lanes exp2(Lanes x) {
  constexpr float kRound = 12582912.0f;  // 1.5 * 2^23: adding it rounds to an integer
  const Lanes shifted = x + kRound;
  const Lanes f = x - (shifted - kRound);
  Lanes y = lanes(1.33908633e-3f);
  y = y * f + 9.67603177e-3f;
  y = y * f + 5.55035695e-2f;
  y = y * f + 0.240221068f;
  y = y * f + 0.693147182f;
  y = y * f + 1.00000012f;
  const LaneMask exponent = reinterpret_cast<LaneMask>(shifted) << 23;
  return reinterpret_cast<Lanes>(reinterpret_cast<LaneMask>(y) + exponent);
}

}  // namespace livegs
