// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "physics/elastic/cells/kernels/cell_lanes.h"

// Algebra on eight cells in parallel: sums over corners, rotations, stretches. Only for the inner loops over
// cells; everything is inlined.

namespace livegs::lanes {

// Coefficients in Hadamard order: 1, x, y, xy, z, xz, yz, xyz.
LIVEGS_INLINE void hadamard(Lanes (&v)[8]) {
  for (int bit = 1; bit < 8; bit *= 2) {
    for (int i = 0; i < 8; ++i) {
      if (i & bit) continue;
      const Lanes low = v[i], high = v[i + bit];
      v[i] = low + high;
      v[i + bit] = high - low;
    }
  }
}

// Inverse without the factor 1/8: corner c gets the sum of coefficient times sign.
LIVEGS_INLINE void hadamard_back(Lanes (&v)[8]) {
  for (int bit = 1; bit < 8; bit *= 2) {
    for (int i = 0; i < 8; ++i) {
      if (i & bit) continue;
      const Lanes low = v[i], high = v[i + bit];
      v[i] = low - high;
      v[i + bit] = low + high;
    }
  }
}

struct Matrix {
  Lanes m[3][3];
};
// Mandel order: 11, 22, 33, 23, 13, 12.
struct Symmetric {
  Lanes v[6];
};

LIVEGS_INLINE Matrix matrix_of(const Lanes (&q)[4]) {
  const Lanes w = q[0], x = q[1], y = q[2], z = q[3];
  const Lanes one = all_lanes(1.0f);
  const Lanes x2 = x + x, y2 = y + y, z2 = z + z;
  const Lanes xx = x * x2, yy = y * y2, zz = z * z2, xy = x * y2, xz = x * z2, yz = y * z2;
  const Lanes wx = w * x2, wy = w * y2, wz = w * z2;
  return {{{one - yy - zz, xy - wz, xz + wy},
           {xy + wz, one - xx - zz, yz - wx},
           {xz - wy, yz + wx, one - xx - yy}}};
}

LIVEGS_INLINE Matrix transposed_times(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      c.m[i][j] = a.m[0][i] * b.m[0][j] + a.m[1][i] * b.m[1][j] + a.m[2][i] * b.m[2][j];
  }
  return c;
}

LIVEGS_INLINE Lanes determinant(const Matrix& a) {
  return a.m[0][0] * (a.m[1][1] * a.m[2][2] - a.m[1][2] * a.m[2][1]) -
         a.m[0][1] * (a.m[1][0] * a.m[2][2] - a.m[1][2] * a.m[2][0]) +
         a.m[0][2] * (a.m[1][0] * a.m[2][1] - a.m[1][1] * a.m[2][0]);
}

// Rotates R so that Rᵀ F becomes more symmetric, in R's own frame. Uses a Newton step if the stretch is
// positive, and the bounded step of Müller et al. 2016 if it is flattened or inverted. The angle is at most
// kMaxTurn_rad.
constexpr float kMaxTurn_rad = 0.5f;
constexpr float kTurnTolerance_rad = 0.05f;  // the remaining error is about its cube

LIVEGS_INLINE Lanes turn(Lanes (&q)[4], const Matrix& m) {
  const Lanes tau[3] = {m.m[2][1] - m.m[1][2], m.m[0][2] - m.m[2][0], m.m[1][0] - m.m[0][1]};
  const Lanes half = all_lanes(0.5f), zero = all_lanes(0.0f), one = all_lanes(1.0f);
  // K = tr(S) I - S
  const Lanes k00 = m.m[1][1] + m.m[2][2], k11 = m.m[0][0] + m.m[2][2], k22 = m.m[0][0] + m.m[1][1];
  const Lanes k12 = -half * (m.m[1][2] + m.m[2][1]), k02 = -half * (m.m[0][2] + m.m[2][0]),
              k01 = -half * (m.m[0][1] + m.m[1][0]);
  const Lanes a00 = k11 * k22 - k12 * k12, a01 = k02 * k12 - k01 * k22, a02 = k01 * k12 - k02 * k11;
  const Lanes a11 = k00 * k22 - k02 * k02, a12 = k01 * k02 - k00 * k12, a22 = k00 * k11 - k01 * k01;
  const Lanes det = k00 * a00 + k01 * a01 + k02 * a02;
  const auto upright = (k00 > all_lanes(0.1f)) & (a22 > all_lanes(0.01f)) & (det > all_lanes(0.001f));
  const Lanes inverse_det = one / (upright ? det : one);
  Lanes w[3] = {(a00 * tau[0] + a01 * tau[1] + a02 * tau[2]) * inverse_det,
                (a01 * tau[0] + a11 * tau[1] + a12 * tau[2]) * inverse_det,
                (a02 * tau[0] + a12 * tau[1] + a22 * tau[2]) * inverse_det};
  const auto fallen = upright == 0;
  bool any_fallen = false;
  for (int l = 0; l < 8; ++l) any_fallen = any_fallen | (fallen[l] != 0);
  if (__builtin_expect(any_fallen, false)) {
    const Lanes trace = m.m[0][0] + m.m[1][1] + m.m[2][2];
    const Lanes scale = one / ((trace < zero ? -trace : trace) + all_lanes(1e-3f));
    // There is no torque at half a turn; a small fixed rotation leaves this unstable equilibrium.
    const Lanes torque = tau[0] * tau[0] + tau[1] * tau[1] + tau[2] * tau[2];
    const auto balanced = fallen & (torque < all_lanes(1e-8f)) & (determinant(m) > all_lanes(0.01f));
    const float kick[3] = {0.01f, 0.02f, 0.03f};
    for (int d = 0; d < 3; ++d) {
      w[d] = upright ? w[d] : tau[d] * scale;
      w[d] = balanced ? all_lanes(kick[d]) : w[d];
    }
  }
  const Lanes length = square_root(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  Lanes shrink = half;
  if (__builtin_expect(any_above(length, kMaxTurn_rad), false)) {
    const Lanes limit = all_lanes(kMaxTurn_rad);
    shrink = half * (length > limit ? limit / length : one);
  }
  const Lanes x = w[0] * shrink, y = w[1] * shrink, z = w[2] * shrink;
  const Lanes n[4] = {q[0] - q[1] * x - q[2] * y - q[3] * z, q[1] + q[0] * x + q[2] * z - q[3] * y,
                      q[2] + q[0] * y + q[3] * x - q[1] * z, q[3] + q[0] * z + q[1] * y - q[2] * x};
  const Lanes inverse = one / square_root(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3]);
  for (int k = 0; k < 4; ++k) q[k] = n[k] * inverse;
  return length;
}

// sym(s G) in Mandel's notation.
LIVEGS_INLINE Symmetric times_mobility(const Symmetric& s, const Lanes (&g)[6]) {
  const Lanes down = all_lanes(static_cast<float>(M_SQRT1_2)), up = all_lanes(static_cast<float>(M_SQRT1_2));
  const Lanes yz = s.v[3] * down, xz = s.v[4] * down, xy = s.v[5] * down;
  const Lanes rows[3][3] = {{s.v[0], xy, xz}, {xy, s.v[1], yz}, {xz, yz, s.v[2]}};
  const Lanes cols[3][3] = {{g[0], g[5], g[4]}, {g[5], g[1], g[3]}, {g[4], g[3], g[2]}};
  Lanes e[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      e[i][j] = rows[i][0] * cols[j][0] + rows[i][1] * cols[j][1] + rows[i][2] * cols[j][2];
  }
  return {{e[0][0], e[1][1], e[2][2], up * (e[1][2] + e[2][1]), up * (e[0][2] + e[2][0]),
           up * (e[0][1] + e[1][0])}};
}

LIVEGS_INLINE Symmetric times_shear(const Lanes (&h)[21], const Symmetric& s) {
  Symmetric r;
  for (int i = 0; i < 6; ++i) r.v[i] = all_lanes(0.0f);
  int k = 0;
  for (int i = 0; i < 6; ++i) {
    r.v[i] += h[k++] * s.v[i];
    for (int j = i + 1; j < 6; ++j, ++k) {
      r.v[i] += h[k] * s.v[j];
      r.v[j] += h[k] * s.v[i];
    }
  }
  return r;
}

LIVEGS_INLINE Lanes dot(const Symmetric& a, const Symmetric& b) {
  Lanes sum = a.v[0] * b.v[0];
  for (int i = 1; i < 6; ++i) sum += a.v[i] * b.v[i];
  return sum;
}

// Cofactor matrix and determinant of a symmetric matrix, in Mandel notation.
LIVEGS_INLINE Symmetric cofactor(const Symmetric& s, Lanes& det) {
  const Lanes down = all_lanes(static_cast<float>(M_SQRT1_2)), up = all_lanes(static_cast<float>(M_SQRT2));
  const Lanes yz = s.v[3] * down, xz = s.v[4] * down, xy = s.v[5] * down;
  const Lanes c00 = s.v[1] * s.v[2] - yz * yz, c01 = xz * yz - xy * s.v[2], c02 = xy * yz - s.v[1] * xz;
  det = s.v[0] * c00 + xy * c01 + xz * c02;
  return {{c00, s.v[0] * s.v[2] - xz * xz, s.v[0] * s.v[1] - xy * xy, up * (xy * xz - s.v[0] * yz), up * c02,
           up * c01}};
}

// Rotates `q` to the rotation of F; returns R and Rᵀ F.
LIVEGS_INLINE void follow_rotation(Lanes (&q)[4], const Matrix& f, Matrix& r, Matrix& m) {
  r = matrix_of(q);
  m = transposed_times(r, f);
  for (int i = 0; i < 8; ++i) {
    const Lanes angle = turn(q, m);
    r = matrix_of(q);
    m = transposed_times(r, f);
    if (!any_above(angle, kTurnTolerance_rad)) break;
  }
}

// Returns S (Mandel), with I - S in `lack` and det F in `volume`.
LIVEGS_INLINE Symmetric strain_of(const Matrix& m, Symmetric& lack, Lanes& volume) {
  const Lanes one = all_lanes(1.0f), up = all_lanes(static_cast<float>(M_SQRT1_2));
  const Symmetric s = {{m.m[0][0], m.m[1][1], m.m[2][2], up * (m.m[1][2] + m.m[2][1]),
                        up * (m.m[0][2] + m.m[2][0]), up * (m.m[0][1] + m.m[1][0])}};
  for (int k = 0; k < 3; ++k) lack.v[k] = one - s.v[k];
  for (int k = 3; k < 6; ++k) lack.v[k] = -s.v[k];
  volume = determinant(m);
  return s;
}

LIVEGS_INLINE Matrix matrix_of_mandel(const Symmetric& s) {
  const Lanes down = all_lanes(static_cast<float>(M_SQRT1_2));
  const Lanes yz = s.v[3] * down, xz = s.v[4] * down, xy = s.v[5] * down;
  return {{{s.v[0], xy, xz}, {xy, s.v[1], yz}, {xz, yz, s.v[2]}}};
}

// Hadamard index of modes 0 ... 3: yz, xz, xy, xyz.
constexpr int kModeIndex[4] = {6, 5, 3, 7};

// F of full cells, with the centroid in their middle; `position` becomes the sums by corner signs.
LIVEGS_INLINE Matrix full_gradient(Lanes inverse_four_widths, Lanes (&position)[3][8]) {
  Matrix f;
  for (int d = 0; d < 3; ++d) {
    hadamard(position[d]);
    f.m[d][0] = position[d][1] * inverse_four_widths;
    f.m[d][1] = position[d][2] * inverse_four_widths;
    f.m[d][2] = position[d][4] * inverse_four_widths;
  }
  return f;
}

// F at a cell's centroid; `position` becomes the sums by corner signs.
LIVEGS_INLINE Matrix gradient_at(const Lanes (&xi)[3], Lanes inverse_four_widths, Lanes (&position)[3][8]) {
  const Lanes yz = xi[1] * xi[2], xz = xi[0] * xi[2], xy = xi[0] * xi[1];
  Matrix f;
  for (int d = 0; d < 3; ++d) {
    Lanes(&h)[8] = position[d];
    hadamard(h);
    f.m[d][0] = (h[1] + xi[1] * h[3] + xi[2] * h[5] + yz * h[7]) * inverse_four_widths;
    f.m[d][1] = (h[2] + xi[0] * h[3] + xi[2] * h[6] + xz * h[7]) * inverse_four_widths;
    f.m[d][2] = (h[4] + xi[0] * h[5] + xi[1] * h[6] + xy * h[7]) * inverse_four_widths;
  }
  return f;
}

}  // namespace livegs::lanes
