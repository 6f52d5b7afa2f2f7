// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#if defined(__SSE2__)
#include <immintrin.h>
#endif

#include <cmath>

// Eight floats as a GCC/Clang vector extension: plain arithmetic on every target. All functions are forced
// inline; a call would pass its values through memory.

namespace livegs {

typedef float Lanes __attribute__((vector_size(32)));      // one value of eight cells, or two nodes
typedef float NodeLanes __attribute__((vector_size(16)));  // x, y, z, w of a node

#define LIVEGS_INLINE [[gnu::always_inline]] static inline

LIVEGS_INLINE Lanes all_lanes(float value) {
  return Lanes{value, value, value, value, value, value, value, value};
}

LIVEGS_INLINE Lanes square_root(Lanes a) {
#if defined(__AVX__)
  return (Lanes)_mm256_sqrt_ps((__m256)a);
#elif defined(__SSE2__)
  const NodeLanes low = (NodeLanes)_mm_sqrt_ps((__m128)__builtin_shufflevector(a, a, 0, 1, 2, 3));
  const NodeLanes high = (NodeLanes)_mm_sqrt_ps((__m128)__builtin_shufflevector(a, a, 4, 5, 6, 7));
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
#else
  Lanes r;
  for (int i = 0; i < 8; ++i) r[i] = std::sqrt(a[i]);
  return r;
#endif
}

LIVEGS_INLINE float largest_lane(Lanes a) {
  float largest = a[0];
  for (int i = 1; i < 8; ++i) largest = a[i] > largest ? a[i] : largest;
  return largest;
}
LIVEGS_INLINE float smallest_lane(Lanes a) { return -largest_lane(-a); }

LIVEGS_INLINE bool any_above(Lanes a, float limit) {
#if defined(__AVX__)
  return _mm256_movemask_ps(_mm256_cmp_ps((__m256)a, _mm256_set1_ps(limit), _CMP_GT_OQ)) != 0;
#else
  return largest_lane(a) > limit;
#endif
}

// In: node i of lanes 0 ... 3 in the low halves and of lanes 4 ... 7 in the high halves. Out: x, y, z, w of
// the eight lanes. Self-inverse.
LIVEGS_INLINE void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  const Lanes t0 = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes t1 = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  const Lanes t2 = __builtin_shufflevector(c, d, 0, 8, 1, 9, 4, 12, 5, 13);
  const Lanes t3 = __builtin_shufflevector(c, d, 2, 10, 3, 11, 6, 14, 7, 15);
  a = __builtin_shufflevector(t0, t2, 0, 1, 8, 9, 4, 5, 12, 13);
  b = __builtin_shufflevector(t0, t2, 2, 3, 10, 11, 6, 7, 14, 15);
  c = __builtin_shufflevector(t1, t3, 0, 1, 8, 9, 4, 5, 12, 13);
  d = __builtin_shufflevector(t1, t3, 2, 3, 10, 11, 6, 7, 14, 15);
}

// Eight rows to eight columns. Self-inverse.
LIVEGS_INLINE void transpose(Lanes (&v)[8]) {
  transpose(v[0], v[1], v[2], v[3]);
  transpose(v[4], v[5], v[6], v[7]);
  for (int i = 0; i < 4; ++i) {
    const Lanes low = v[i], high = v[i + 4];
    v[i] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 8, 9, 10, 11);
    v[i + 4] = __builtin_shufflevector(low, high, 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

LIVEGS_INLINE Lanes pair_of(NodeLanes low, NodeLanes high) {
  return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}
LIVEGS_INLINE NodeLanes low_half(Lanes a) { return __builtin_shufflevector(a, a, 0, 1, 2, 3); }
LIVEGS_INLINE NodeLanes high_half(Lanes a) { return __builtin_shufflevector(a, a, 4, 5, 6, 7); }

// Cross product of the x, y, z of both nodes; w becomes 0.
LIVEGS_INLINE Lanes cross_pairs(Lanes a, Lanes b) {
  const Lanes a1 = __builtin_shufflevector(a, a, 1, 2, 0, 3, 5, 6, 4, 7);
  const Lanes b1 = __builtin_shufflevector(b, b, 1, 2, 0, 3, 5, 6, 4, 7);
  const Lanes c = a * b1 - a1 * b;
  return __builtin_shufflevector(c, c, 1, 2, 0, 3, 5, 6, 4, 7);
}

}  // namespace livegs
