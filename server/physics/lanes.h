// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>

// Four doubles side by side, one a cell, as GCC's and Clang's vector extension: plain arithmetic on every target.

namespace livegs {

typedef double Lanes __attribute__((vector_size(32)));

inline Lanes all_lanes(double value) { return Lanes{value, value, value, value}; }

inline Lanes square_root(Lanes a) { return Lanes{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])}; }

inline double largest_lane(Lanes a) {
  const double low = a[0] > a[1] ? a[0] : a[1], high = a[2] > a[3] ? a[2] : a[3];
  return low > high ? low : high;
}
inline double smallest_lane(Lanes a) { return -largest_lane(-a); }

// Rows to columns: four (x, y, z, w) become x of all, y of all, z of all, w of all; its own inverse.
inline void transpose(Lanes& a, Lanes& b, Lanes& c, Lanes& d) {
  const Lanes t0 = __builtin_shufflevector(a, b, 0, 4, 2, 6), t1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const Lanes t2 = __builtin_shufflevector(c, d, 0, 4, 2, 6), t3 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(t0, t2, 0, 1, 4, 5);
  b = __builtin_shufflevector(t1, t3, 0, 1, 4, 5);
  c = __builtin_shufflevector(t0, t2, 2, 3, 6, 7);
  d = __builtin_shufflevector(t1, t3, 2, 3, 6, 7);
}

}  // namespace livegs
