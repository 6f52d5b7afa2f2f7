// SPDX-License-Identifier: GPL-3.0-or-later
// Corotated elasticity of an eight-node cell as one XPBD block (Macklin et al. 2016, XPBD; Müller and Chentanez 2022,
// Physically based shape matching; elastic-study.md 2.2 to 2.5):
//   F = sum x_i g_iᵀ, R its rotation, S = sym(Rᵀ F), energy V [ mu |S - I|² + lambda/2 (det F - 1)² ]
//   d     = H (I - S)                                              the mu part, solved exactly
//   S1    = S + sym(d G),  c = cof S1
//   p     = (1 - det S1) / (c·A c - A c·H A c + alpha_lambda)      the volume part, Schur complement of the first
//   sigma = d - p H A c + p c,   x_i += w_i R sigma g_i
// then bending and twisting modes, which mean strain does not see, each with its own stiffness.
// The eight corner sums, in and out, are one Hadamard transform of the corner signs.
#include "physics/cell_sweep.h"

#include "core/assert.h"

namespace livegs {
namespace {

// The small functions are inlined by order: a call passes hundreds of bytes of lanes through memory.

// In Hadamard order: 1, x, y, xy, z, xz, yz, xyz.
[[gnu::always_inline]] inline void hadamard(Lanes (&v)[8]) {
  for (int bit = 1; bit < 8; bit *= 2) {
    for (int i = 0; i < 8; ++i) {
      if (i & bit) continue;
      const Lanes low = v[i], high = v[i + bit];
      v[i] = low + high;
      v[i + bit] = high - low;
    }
  }
}

// The inverse without its factor: corner c gets sum of coefficient times sign.
[[gnu::always_inline]] inline void hadamard_back(Lanes (&v)[8]) {
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
// Mandel order 11, 22, 33, 23, 13, 12.
struct Symmetric {
  Lanes v[6];
};

[[gnu::always_inline]] inline Matrix matrix_of(const Lanes (&q)[4]) {
  const Lanes w = q[0], x = q[1], y = q[2], z = q[3];
  const Lanes one = all_lanes(1.0), two = all_lanes(2.0);
  return {{{one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)},
           {two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)},
           {two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)}}};
}

[[gnu::always_inline]] inline Matrix transposed_times(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) c.m[i][j] = a.m[0][i] * b.m[0][j] + a.m[1][i] * b.m[1][j] + a.m[2][i] * b.m[2][j];
  }
  return c;
}

Lanes determinant(const Matrix& a) {
  return a.m[0][0] * (a.m[1][1] * a.m[2][2] - a.m[1][2] * a.m[2][1]) -
         a.m[0][1] * (a.m[1][0] * a.m[2][2] - a.m[1][2] * a.m[2][0]) +
         a.m[0][2] * (a.m[1][0] * a.m[2][1] - a.m[1][1] * a.m[2][0]);
}

// A turn of R that makes Rᵀ F more symmetric, in R's own frame: Newton's step where the stretch is upright, the
// bounded step of Müller et al. 2016 where it is not (flattened, inverted). Never more than kLargestTurn.
constexpr double kLargestTurn = 0.5;
constexpr double kConverged = 0.05;  // rad; the error left is about its cube
constexpr int kMaxTurns = 8;

[[gnu::always_inline]] inline Lanes turn(Lanes (&q)[4], const Matrix& f) {
  const Matrix m = transposed_times(matrix_of(q), f);
  const Lanes tau[3] = {m.m[2][1] - m.m[1][2], m.m[0][2] - m.m[2][0], m.m[1][0] - m.m[0][1]};
  const Lanes half = all_lanes(0.5), zero = all_lanes(0.0), one = all_lanes(1.0);
  // K = tr(S) I - S
  const Lanes k00 = m.m[1][1] + m.m[2][2], k11 = m.m[0][0] + m.m[2][2], k22 = m.m[0][0] + m.m[1][1];
  const Lanes k12 = -half * (m.m[1][2] + m.m[2][1]), k02 = -half * (m.m[0][2] + m.m[2][0]),
              k01 = -half * (m.m[0][1] + m.m[1][0]);
  const Lanes a00 = k11 * k22 - k12 * k12, a01 = k02 * k12 - k01 * k22, a02 = k01 * k12 - k02 * k11;
  const Lanes a11 = k00 * k22 - k02 * k02, a12 = k01 * k02 - k00 * k12, a22 = k00 * k11 - k01 * k01;
  const Lanes det = k00 * a00 + k01 * a01 + k02 * a02;
  const Lanes trace = m.m[0][0] + m.m[1][1] + m.m[2][2];
  const auto upright = (k00 > all_lanes(0.1)) & (a22 > all_lanes(0.01)) & (det > all_lanes(0.001));
  const Lanes safe_det = upright ? det : one;
  const Lanes scale = one / ((trace < zero ? -trace : trace) + all_lanes(1e-3));
  Lanes w[3] = {a00 * tau[0] + a01 * tau[1] + a02 * tau[2], a01 * tau[0] + a11 * tau[1] + a12 * tau[2],
                a02 * tau[0] + a12 * tau[1] + a22 * tau[2]};
  // A half turn away there is no torque; a fixed small turn leaves that balance.
  const Lanes torque = tau[0] * tau[0] + tau[1] * tau[1] + tau[2] * tau[2];
  const auto balanced = ~upright & (torque < all_lanes(1e-8)) & (determinant(m) > all_lanes(0.01));
  const double kick[3] = {0.01, 0.02, 0.03};
  for (int d = 0; d < 3; ++d) {
    w[d] = upright ? w[d] / safe_det : tau[d] * scale;
    w[d] = balanced ? all_lanes(kick[d]) : w[d];
  }
  const Lanes length = square_root(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const Lanes limit = all_lanes(kLargestTurn);
  const Lanes shrink = half * (length > limit ? limit / length : one);
  const Lanes x = w[0] * shrink, y = w[1] * shrink, z = w[2] * shrink;
  const Lanes n[4] = {q[0] - q[1] * x - q[2] * y - q[3] * z, q[1] + q[0] * x + q[2] * z - q[3] * y,
                      q[2] + q[0] * y + q[3] * x - q[1] * z, q[3] + q[0] * z + q[1] * y - q[2] * x};
  const Lanes inverse = one / square_root(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3]);
  for (int k = 0; k < 4; ++k) q[k] = n[k] * inverse;
  return length;
}

constexpr double kRoot2 = 1.41421356237309504880, kHalfRoot2 = 0.70710678118654752440;

// sym(s G) in Mandel's notation.
[[gnu::always_inline]] inline Symmetric times_mobility(const Symmetric& s, const Lanes (&g)[6]) {
  const Lanes down = all_lanes(kHalfRoot2), half = all_lanes(0.5);
  const Lanes yz = s.v[3] * down, xz = s.v[4] * down, xy = s.v[5] * down;
  const Lanes rows[3][3] = {{s.v[0], xy, xz}, {xy, s.v[1], yz}, {xz, yz, s.v[2]}};
  const Lanes cols[3][3] = {{g[0], g[5], g[4]}, {g[5], g[1], g[3]}, {g[4], g[3], g[2]}};
  const auto entry = [&](int i, int j) {
    return rows[i][0] * cols[j][0] + rows[i][1] * cols[j][1] + rows[i][2] * cols[j][2];
  };
  const Lanes up = half * all_lanes(kRoot2);
  return {{entry(0, 0), entry(1, 1), entry(2, 2), up * (entry(1, 2) + entry(2, 1)), up * (entry(0, 2) + entry(2, 0)),
           up * (entry(0, 1) + entry(1, 0))}};
}

[[gnu::always_inline]] inline Symmetric times_shear(const Lanes (&h)[21], const Symmetric& s) {
  Symmetric r;
  for (int i = 0; i < 6; ++i) r.v[i] = all_lanes(0.0);
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

Lanes dot(const Symmetric& a, const Symmetric& b) {
  Lanes sum = a.v[0] * b.v[0];
  for (int i = 1; i < 6; ++i) sum += a.v[i] * b.v[i];
  return sum;
}

// Cofactor matrix and determinant of a symmetric matrix, both Mandel.
[[gnu::always_inline]] inline Symmetric cofactor(const Symmetric& s, Lanes& det) {
  const Lanes down = all_lanes(kHalfRoot2), up = all_lanes(kRoot2);
  const Lanes yz = s.v[3] * down, xz = s.v[4] * down, xy = s.v[5] * down;
  const Lanes c00 = s.v[1] * s.v[2] - yz * yz, c01 = xz * yz - xy * s.v[2], c02 = xy * yz - s.v[1] * xz;
  det = s.v[0] * c00 + xy * c01 + xz * c02;
  return {{c00, s.v[0] * s.v[2] - xz * xz, s.v[0] * s.v[1] - xy * xy, up * (xy * xz - s.v[0] * yz), up * c02,
           up * c01}};
}

// The Hadamard index of mode 0 ... 3: yz, xz, xy, xyz.
constexpr int kModeIndex[4] = {6, 5, 3, 7};

void solve_batch(CellBatch& batch, const BatchGains& gains, const NodeLanes* predicted, NodeLanes* corrections,
                 Lanes& worst_strain, Lanes& least_volume) {
  const Lanes one = all_lanes(1.0);
  Lanes position[3][8], inverse_mass[8];
  for (int c = 0; c < 8; ++c) {
    const auto& n = batch.nodes[c];
    Lanes rows[4];
    for (int l = 0; l < 4; ++l) rows[l] = predicted[n[l]].value + corrections[n[l]].value;
    transpose(rows[0], rows[1], rows[2], rows[3]);
    for (int d = 0; d < 3; ++d) position[d][c] = rows[d];
    inverse_mass[c] = rows[3];
  }
  for (int d = 0; d < 3; ++d) hadamard(position[d]);

  const Lanes(&xi)[3] = batch.centroid;
  const Lanes yz = xi[1] * xi[2], xz = xi[0] * xi[2], xy = xi[0] * xi[1];
  Matrix f;
  for (int d = 0; d < 3; ++d) {
    const Lanes(&h)[8] = position[d];
    f.m[d][0] = (h[1] + xi[1] * h[3] + xi[2] * h[5] + yz * h[7]) * batch.inverse_four_widths;
    f.m[d][1] = (h[2] + xi[0] * h[3] + xi[2] * h[6] + xz * h[7]) * batch.inverse_four_widths;
    f.m[d][2] = (h[4] + xi[0] * h[5] + xi[1] * h[6] + xy * h[7]) * batch.inverse_four_widths;
  }
  for (int i = 0; i < kMaxTurns; ++i) {
    if (largest_lane(turn(batch.rotation, f)) < kConverged) break;
  }
  const Matrix r = matrix_of(batch.rotation);
  const Matrix m = transposed_times(r, f);
  const Lanes up = all_lanes(0.5 * kRoot2);
  const Symmetric s = {{m.m[0][0], m.m[1][1], m.m[2][2], up * (m.m[1][2] + m.m[2][1]), up * (m.m[0][2] + m.m[2][0]),
                        up * (m.m[0][1] + m.m[1][0])}};

  Symmetric lack = s;  // I - S
  for (int k = 0; k < 6; ++k) lack.v[k] = (k < 3 ? one : all_lanes(0.0)) - s.v[k];
  const Lanes strain = dot(lack, lack);
  const Lanes volume = determinant(f);
  // Unused places have F = 0 and no stiffness; they are not strained.
  const auto used = batch.mobility[0] + batch.mobility[1] + batch.mobility[2] > all_lanes(0.0);
  worst_strain = used & (strain > worst_strain) ? strain : worst_strain;
  least_volume = used & (volume < least_volume) ? volume : least_volume;

  const Symmetric shear = times_shear(gains.shear, lack);
  const Symmetric moved = times_mobility(shear, batch.mobility);
  Symmetric s1;
  for (int k = 0; k < 6; ++k) s1.v[k] = s.v[k] + moved.v[k];
  Lanes det;
  const Symmetric c = cofactor(s1, det);
  const Symmetric ac = times_mobility(c, batch.mobility);
  const Symmetric hac = times_shear(gains.shear, ac);
  const Lanes p = (one - det) / (dot(c, ac) - dot(ac, hac) + gains.volume_compliance);
  Symmetric sigma;
  for (int k = 0; k < 6; ++k) sigma.v[k] = shear.v[k] + p * (c.v[k] - hac.v[k]);

  const Lanes down = all_lanes(kHalfRoot2);
  const Lanes syz = sigma.v[3] * down, sxz = sigma.v[4] * down, sxy = sigma.v[5] * down;
  const Lanes stress[3][3] = {{sigma.v[0], sxy, sxz}, {sxy, sigma.v[1], syz}, {sxz, syz, sigma.v[2]}};

  // Mode amplitudes after the strain update, in the turned frame, and what their rows give back.
  Lanes eta[4][3];
  for (int j = 0; j < 4; ++j) {
    const Lanes* coupling = batch.mode_coupling[j];
    const int k = kModeIndex[j];
    for (int d = 0; d < 3; ++d) {
      const Lanes turned = r.m[0][d] * position[0][k] + r.m[1][d] * position[1][k] + r.m[2][d] * position[2][k];
      const Lanes pulled = stress[d][0] * coupling[0] + stress[d][1] * coupling[1] + stress[d][2] * coupling[2];
      eta[j][d] = -gains.mode[j][d] * (turned + pulled) * all_lanes(0.125);
    }
  }

  // Coefficients of the corner signs in the turned frame, then turned to world axes.
  Lanes coefficient[8][3];
  for (int d = 0; d < 3; ++d) {
    const Lanes tx = stress[d][0] * batch.inverse_four_widths, ty = stress[d][1] * batch.inverse_four_widths,
                tz = stress[d][2] * batch.inverse_four_widths;
    const Lanes eighth = all_lanes(0.125);
    coefficient[0][d] = all_lanes(0.0);
    coefficient[1][d] = tx;
    coefficient[2][d] = ty;
    coefficient[3][d] = xi[1] * tx + xi[0] * ty + eighth * eta[2][d];
    coefficient[4][d] = tz;
    coefficient[5][d] = xi[2] * tx + xi[0] * tz + eighth * eta[1][d];
    coefficient[6][d] = xi[2] * ty + xi[1] * tz + eighth * eta[0][d];
    coefficient[7][d] = yz * tx + xz * ty + xy * tz + eighth * eta[3][d];
  }
  Lanes out[3][8];
  for (int k = 0; k < 8; ++k) {
    for (int d = 0; d < 3; ++d) {
      out[d][k] = r.m[d][0] * coefficient[k][0] + r.m[d][1] * coefficient[k][1] + r.m[d][2] * coefficient[k][2];
    }
  }
  for (int d = 0; d < 3; ++d) hadamard_back(out[d]);
  for (int c8 = 0; c8 < 8; ++c8) {
    const auto& n = batch.nodes[c8];
    const Lanes w = inverse_mass[c8];
    Lanes rows[4] = {w * out[0][c8], w * out[1][c8], w * out[2][c8], all_lanes(0.0)};
    transpose(rows[0], rows[1], rows[2], rows[3]);
    for (int l = 0; l < 4; ++l) corrections[n[l]].value += rows[l];
  }
}

}  // namespace

SweepReport sweep_cells(std::span<CellBatch> batches, std::span<const BatchGains> gains,
                        std::span<const NodeLanes> predicted, std::span<NodeLanes> corrections) {
  LIVEGS_ASSERT(batches.size() == gains.size() && predicted.size() == corrections.size());
  Lanes strain = all_lanes(0.0), volume = all_lanes(1.0);
  for (size_t i = 0; i < batches.size(); ++i) {
    solve_batch(batches[i], gains[i], predicted.data(), corrections.data(), strain, volume);
  }
  return {largest_lane(strain), smallest_lane(volume)};
}

}  // namespace livegs
