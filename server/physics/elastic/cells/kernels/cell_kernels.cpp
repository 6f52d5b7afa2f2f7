// SPDX-License-Identifier: GPL-3.0-or-later
// Corotated elasticity of an eight-node cell as one XPBD block (Macklin et al. 2016, XPBD; Müller and
// Chentanez 2022, Physically based shape matching):
//   F = sum x_i g_iᵀ, R its rotation, S = sym(Rᵀ F), energy V [ mu |S - I|² + lambda/2 (det F - 1)² ]
//   (with the plastic part D in place of I after plastic flow)
//   d     = H (I - S)                                           mu part, solved exactly
//   S1    = S + sym(d G),  c = cof S1
//   p     = (1 - det S1) / (c·A c - A c·H A c + alpha_lambda)   volume part, Schur complement of the first
//   sigma = d - p H A c + p c,   x_i += w_i R sigma g_i
// Bending and twisting modes, which mean strain does not contain, follow, each with its own stiffness. The
// sums over the eight corners, in and out, are one Hadamard transform of the corner signs.
#include "physics/elastic/cells/kernels/cell_kernels.h"

#include "physics/elastic/cells/kernels/cell_algebra.h"

namespace livegs {
namespace {

using namespace lanes;

typedef float Unaligned __attribute__((vector_size(32), aligned(16)));
LIVEGS_INLINE Lanes two_nodes(const NodeLanes* p) { return *reinterpret_cast<const Unaligned*>(p); }

// Loads the corner positions (y plus the corrections so far) and inverse masses. kPaired: corners 2k and 2k +
// 1 of every cell are adjacent in the arrays, as in lattices without virtual nodes.
template <bool kPaired>
LIVEGS_INLINE void gather(const uint32_t (&nodes)[8][8], const NodeLanes* predicted,
                          const NodeLanes* corrections, Lanes (&position)[3][8], Lanes (&inverse_mass)[8]) {
  for (int c = 0; c < 8; c += 2) {
    const uint32_t *n = nodes[c], *m = nodes[c + 1];
    Lanes rows[8];
    for (int l = 0; l < 8; ++l) {
      rows[l] = kPaired ? two_nodes(predicted + n[l]) + two_nodes(corrections + n[l])
                        : pair_of(predicted[n[l]] + corrections[n[l]], predicted[m[l]] + corrections[m[l]]);
    }
    transpose(rows);
    for (int d = 0; d < 3; ++d) {
      position[d][c] = rows[d];
      position[d][c + 1] = rows[d + 4];
    }
    inverse_mass[c] = rows[3];
    inverse_mass[c + 1] = rows[7];
  }
}

template <bool kPaired>
LIVEGS_INLINE void scatter(const uint32_t (&nodes)[8][8], const Lanes (&inverse_mass)[8],
                           const Lanes (&pull)[3][8], NodeLanes* corrections) {
  for (int c = 0; c < 8; c += 2) {
    const uint32_t *n = nodes[c], *m = nodes[c + 1];
    const Lanes w = inverse_mass[c], w1 = inverse_mass[c + 1];
    Lanes rows[8] = {w * pull[0][c],      w * pull[1][c],      w * pull[2][c],      all_lanes(0.0f),
                     w1 * pull[0][c + 1], w1 * pull[1][c + 1], w1 * pull[2][c + 1], all_lanes(0.0f)};
    transpose(rows);
    for (int l = 0; l < 8; ++l) {
      if (kPaired) {
        Unaligned& both = *reinterpret_cast<Unaligned*>(corrections + n[l]);
        both += rows[l];
      } else {
        corrections[n[l]] += low_half(rows[l]);
        corrections[m[l]] += high_half(rows[l]);
      }
    }
  }
}

// Force from the dependence of R on F. If the stress T depends on the stretch U only (no plastic part, no
// bending), it is zero. Otherwise the force is R (T + A), with A antisymmetric and axial vector (tr U I -
// U)^-1 (axial(U T - T U) - sum z_j x eta_j); z_j are the mode amplitudes and eta_j their forces. The factor
// (tr U I - U)^-1 uses the mean of U. Without A, bent cells add energy to the body. A is not part of the
// solved block, so its effect on F is limited to kMaxTurningPart of the cell's strain.
constexpr float kMaxTurningPart = 0.3f;
LIVEGS_INLINE void add_turning_force(const Matrix& m, const Lanes (&mode_torque)[3], Lanes strain_squared,
                                     Lanes mobility, Matrix& stress) {
  const Lanes trace = m.m[0][0] + m.m[1][1] + m.m[2][2], least = all_lanes(1.5f), one = all_lanes(1.0f);
  const Lanes share = all_lanes(1.5f) / (trace > least ? trace : least);
  Lanes axial[3], squared = all_lanes(0.0f);
  for (int d = 0; d < 3; ++d) {
    const int i = (d + 2) % 3, j = (d + 1) % 3;  // component d of the axial vector is element (i, j)
    Lanes commutator = all_lanes(0.0f);
    for (int k = 0; k < 3; ++k) commutator += m.m[i][k] * stress.m[k][j] - stress.m[i][k] * m.m[k][j];
    axial[d] = share * (commutator - mode_torque[d]);
    squared += axial[d] * axial[d];
  }
  const Lanes most = all_lanes(kMaxTurningPart * kMaxTurningPart) * strain_squared,
              moved = squared * mobility * mobility;
  const Lanes kept = moved > most ? square_root(most / moved) : one;
  for (int d = 0; d < 3; ++d) {
    const int i = (d + 2) % 3, j = (d + 1) % 3;
    stress.m[i][j] += kept * axial[d];
    stress.m[j][i] -= kept * axial[d];
  }
}

LIVEGS_INLINE void add_cross(const Lanes (&a)[3], const Lanes (&b)[3], Lanes (&sum)[3]) {
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    sum[d] += a[e] * b[f] - a[f] * b[e];
  }
}

struct Worst {
  Lanes strain, bent, volume;
};

// A fold leaves no strain at the centroid. Bending therefore counts as the strain of a full cell's faces: its
// square is (4 q / a)² for an amplitude q, 256 q² over (4 a)². The sums by corner signs are 8 q.
template <class Mask>
LIVEGS_INLINE void report(Mask used, Lanes strain, Lanes bending, Lanes volume, Worst& worst) {
  const Lanes bent = strain + bending;
  worst.strain = (used & (strain > worst.strain)) ? strain : worst.strain;
  worst.bent = (used & (bent > worst.bent)) ? bent : worst.bent;
  worst.volume = (used & (volume < worst.volume)) ? volume : worst.volume;
}

// Converts coefficients of the corner signs in the rotated frame to impulses on the corners in world axes.
LIVEGS_INLINE void to_corners(const Matrix& r, const Lanes (&coefficient)[8][3], Lanes (&out)[3][8]) {
  for (int d = 0; d < 3; ++d) {
    out[d][0] = all_lanes(0.0f);
    for (int k = 1; k < 8; ++k) {
      out[d][k] =
          r.m[d][0] * coefficient[k][0] + r.m[d][1] * coefficient[k][1] + r.m[d][2] * coefficient[k][2];
    }
    hadamard_back(out[d]);
  }
}

// Impulses on the corners from the stress at the centroid and the mode forces, both in the rotated frame.
LIVEGS_INLINE void pull_corners(const Matrix& r, const Matrix& stress, const Lanes (&eta)[4][3],
                                const Lanes (&xi)[3], Lanes inverse_four_widths, Lanes (&out)[3][8]) {
  const Lanes yz = xi[1] * xi[2], xz = xi[0] * xi[2], xy = xi[0] * xi[1];
  Lanes coefficient[8][3];
  for (int d = 0; d < 3; ++d) {
    const Lanes tx = stress.m[d][0] * inverse_four_widths, ty = stress.m[d][1] * inverse_four_widths,
                tz = stress.m[d][2] * inverse_four_widths;
    coefficient[1][d] = tx;
    coefficient[2][d] = ty;
    coefficient[3][d] = xi[1] * tx + xi[0] * ty + eta[2][d];
    coefficient[4][d] = tz;
    coefficient[5][d] = xi[2] * tx + xi[0] * tz + eta[1][d];
    coefficient[6][d] = xi[2] * ty + xi[1] * tz + eta[0][d];
    coefficient[7][d] = yz * tx + xz * ty + xy * tz + eta[3][d];
  }
  to_corners(r, coefficient, out);
}

template <bool kPaired>
LIVEGS_INLINE void solve_full(FullCells& cells, const FullGains& gains, const GaussSeidelArrays& arrays,
                              Worst& worst) {
  Lanes position[3][8], inverse_mass[8];
  gather<kPaired>(cells.nodes, arrays.predicted, arrays.corrections, position, inverse_mass);
  const Lanes q4 = all_lanes(arrays.inverse_four_widths);
  const Matrix f = full_gradient(q4, position);
  Matrix r, m;
  follow_rotation(cells.rotation, f, r, m);
  Symmetric lack;
  Lanes volume;
  const Symmetric s = strain_of(m, lack, volume);

  // G = g I, so A and H are multiples of the identity.
  const Lanes h = all_lanes(gains.shear), gh = all_lanes(gains.mobility * gains.shear);
  const Lanes left = all_lanes(1.0f - gains.mobility * gains.shear);
  Symmetric s1;
  for (int k = 0; k < 6; ++k) s1.v[k] = s.v[k] + gh * lack.v[k];
  Lanes det;
  const Symmetric c = cofactor(s1, det);
  const Lanes p = (all_lanes(1.0f) - det) /
                  (dot(c, c) * all_lanes(gains.mobility) * left + all_lanes(gains.volume_compliance)) * left;
  Symmetric sigma;
  for (int k = 0; k < 6; ++k) sigma.v[k] = h * lack.v[k] + p * c.v[k];
  const Matrix stress = matrix_of_mandel(sigma);

  Lanes coefficient[8][3], bent = all_lanes(0.0f);
  for (int d = 0; d < 3; ++d) {
    coefficient[1][d] = stress.m[d][0] * q4;
    coefficient[2][d] = stress.m[d][1] * q4;
    coefficient[4][d] = stress.m[d][2] * q4;
    for (int j = 0; j < 4; ++j) {
      const int k = kModeIndex[j];
      const Lanes turned =
          r.m[0][d] * position[0][k] + r.m[1][d] * position[1][k] + r.m[2][d] * position[2][k];
      coefficient[k][d] = turned * all_lanes(-gains.mode[j][d] / 64.0f);
      bent += turned * turned;
    }
  }
  report(inverse_mass[0] > all_lanes(0.0f), dot(lack, lack), all_lanes(256.0f / 64.0f) * q4 * q4 * bent,
         volume, worst);
  Lanes out[3][8];
  to_corners(r, coefficient, out);
  scatter<kPaired>(cells.nodes, inverse_mass, out, arrays.corrections);
}

template <bool kPaired, bool kPlastic>
LIVEGS_INLINE void solve_cut(CutCells& cells, const PlasticCells* plastic, const CutGains& gains,
                             const GaussSeidelArrays& arrays, Worst& worst) {
  Lanes position[3][8], inverse_mass[8];
  gather<kPaired>(cells.nodes, arrays.predicted, arrays.corrections, position, inverse_mass);
  const Lanes q4 = all_lanes(arrays.inverse_four_widths);
  Matrix r, m;
  follow_rotation(cells.rotation, gradient_at(cells.centroid, q4, position), r, m);
  Symmetric lack;
  Lanes volume;
  const Symmetric s = strain_of(m, lack, volume);
  if (kPlastic) {
    for (int k = 0; k < 6; ++k) lack.v[k] = plastic->part[k] - s.v[k];
  }
  const Symmetric shear = times_shear(gains.shear, lack);
  const Symmetric moved = times_mobility(shear, cells.mobility);
  Symmetric s1;
  for (int k = 0; k < 6; ++k) s1.v[k] = s.v[k] + moved.v[k];
  Lanes det;
  const Symmetric c = cofactor(s1, det);
  const Symmetric ac = times_mobility(c, cells.mobility);
  const Symmetric hac = times_shear(gains.shear, ac);
  const Lanes p = (all_lanes(1.0f) - det) / (dot(c, ac) - dot(ac, hac) + gains.volume_compliance);
  Symmetric sigma;
  for (int k = 0; k < 6; ++k) sigma.v[k] = shear.v[k] + p * (c.v[k] - hac.v[k]);
  Matrix stress = matrix_of_mandel(sigma);
  if (kPlastic) {
    // The torque of the modes is omitted for these cells; its effect has not been measured.
    const Lanes torque[3] = {all_lanes(0.0f), all_lanes(0.0f), all_lanes(0.0f)};
    add_turning_force(m, torque, dot(lack, lack), cells.mobility[0] + cells.mobility[1] + cells.mobility[2],
                      stress);
  }

  // Mode amplitudes after the strain update, in the rotated frame, and the resulting mode forces.
  Lanes eta[4][3], bent = all_lanes(0.0f);
  for (int j = 0; j < 4; ++j) {
    const Lanes(&coupling)[3] = cells.mode_coupling[j];
    const int k = kModeIndex[j];
    for (int d = 0; d < 3; ++d) {
      Lanes turned = r.m[0][d] * position[0][k] + r.m[1][d] * position[1][k] + r.m[2][d] * position[2][k];
      if (kPlastic) turned -= all_lanes(8.0f) * plastic->mode_rest[j][d];
      bent += turned * turned;
      const Lanes pulled =
          stress.m[d][0] * coupling[0] + stress.m[d][1] * coupling[1] + stress.m[d][2] * coupling[2];
      eta[j][d] = gains.mode[j][d] * (turned + pulled) * all_lanes(-1.0f / 64.0f);
    }
  }
  // Unused lanes have F = 0 and no stiffness; they are excluded from the report.
  report(cells.mobility[0] + cells.mobility[1] + cells.mobility[2] > all_lanes(0.0f), dot(lack, lack),
         all_lanes(256.0f / 64.0f) * q4 * q4 * bent, volume, worst);

  Lanes out[3][8];
  pull_corners(r, stress, eta, cells.centroid, q4, out);
  scatter<kPaired>(cells.nodes, inverse_mass, out, arrays.corrections);
}

// Solves all eighteen measures at once; the energy is quadratic in them, so there is no volume row.
template <bool kPaired, bool kPlastic>
LIVEGS_INLINE void solve_thin(ThinCells& cells, const PlasticCells* plastic, const ThinGains& gains,
                              const GaussSeidelArrays& arrays, Worst& worst) {
  Lanes position[3][8], inverse_mass[8];
  gather<kPaired>(cells.nodes, arrays.predicted, arrays.corrections, position, inverse_mass);
  const Lanes q4 = all_lanes(arrays.inverse_four_widths);
  Matrix r, m;
  follow_rotation(cells.rotation, gradient_at(cells.centroid, q4, position), r, m);
  Symmetric lack;
  Lanes volume;
  const Symmetric s = strain_of(m, lack, volume);
  if (kPlastic) {
    for (int k = 0; k < 6; ++k) lack.v[k] = plastic->part[k] - s.v[k];
  }
  Lanes lacking[18], impulse[18], modes[4][3];
  for (int k = 0; k < 6; ++k) lacking[k] = lack.v[k];
  for (int j = 0; j < 4; ++j) {
    const int k = kModeIndex[j];
    for (int d = 0; d < 3; ++d) {
      const Lanes turned =
          r.m[0][d] * position[0][k] + r.m[1][d] * position[1][k] + r.m[2][d] * position[2][k];
      modes[j][d] = turned * all_lanes(0.125f);
      lacking[6 + 3 * j + d] = -modes[j][d];
      if (kPlastic) lacking[6 + 3 * j + d] += plastic->mode_rest[j][d];
    }
  }
  Lanes bent = all_lanes(0.0f);
  for (int k = 6; k < 18; ++k) bent += lacking[k] * lacking[k];
  const auto used = cells.mobility > all_lanes(0.0f);
  const Lanes strain = dot(lack, lack) + cells.fold * bent;
  report(used, strain, all_lanes(0.0f), volume, worst);

  for (int i = 0; i < 18; ++i) impulse[i] = all_lanes(0.0f);
  const Lanes* gain = gains.gain;
  for (int i = 0; i < 18; ++i) {
    Lanes sum = *gain++ * lacking[i];
    for (int j = i + 1; j < 18; ++j) {
      sum += *gain * lacking[j];
      impulse[j] += *gain++ * lacking[i];
    }
    impulse[i] += sum;
  }
  Symmetric sigma;
  for (int k = 0; k < 6; ++k) sigma.v[k] = impulse[k];
  Matrix stress = matrix_of_mandel(sigma);
  Lanes torque[3] = {all_lanes(0.0f), all_lanes(0.0f), all_lanes(0.0f)};
  for (int j = 0; j < 4; ++j)
    add_cross(modes[j], {impulse[6 + 3 * j], impulse[7 + 3 * j], impulse[8 + 3 * j]}, torque);
  add_turning_force(m, torque, dot(lack, lack) + all_lanes(256.0f) * q4 * q4 * bent, cells.mobility, stress);
  Lanes eta[4][3];
  for (int j = 0; j < 4; ++j) {
    for (int d = 0; d < 3; ++d) eta[j][d] = all_lanes(0.125f) * impulse[6 + 3 * j + d];
  }
  Lanes out[3][8];
  pull_corners(r, stress, eta, cells.centroid, q4, out);
  scatter<kPaired>(cells.nodes, inverse_mass, out, arrays.corrections);
}

}  // namespace

GaussSeidelReport gauss_seidel_pass(const GaussSeidelArrays& arrays, const CellColours& colours) {
  Worst worst{all_lanes(0.0f), all_lanes(0.0f), all_lanes(1.0f)};
  for (int i = 0; i < 16; ++i) {
    const int colour = arrays.backward ? 15 - i : i;
    for (size_t k = colours.full_begin[colour]; k < colours.full_begin[colour + 1]; ++k) {
      if (arrays.paired) {
        solve_full<true>(arrays.full[k], arrays.full_gains, arrays, worst);
      } else {
        solve_full<false>(arrays.full[k], arrays.full_gains, arrays, worst);
      }
    }
    for (size_t k = colours.cut_begin[colour]; k < colours.cut_begin[colour + 1]; ++k) {
      if (arrays.plastic) {
        solve_cut<false, true>(arrays.cut[k], arrays.plastic + k, arrays.gains[k], arrays, worst);
      } else if (arrays.paired) {
        solve_cut<true, false>(arrays.cut[k], nullptr, arrays.gains[k], arrays, worst);
      } else {
        solve_cut<false, false>(arrays.cut[k], nullptr, arrays.gains[k], arrays, worst);
      }
    }
    for (size_t k = colours.thin_begin[colour]; k < colours.thin_begin[colour + 1]; ++k) {
      if (arrays.thin_plastic) {
        solve_thin<false, true>(arrays.thin[k], arrays.thin_plastic + k, arrays.thin_gains[k], arrays, worst);
      } else if (arrays.paired) {
        solve_thin<true, false>(arrays.thin[k], nullptr, arrays.thin_gains[k], arrays, worst);
      } else {
        solve_thin<false, false>(arrays.thin[k], nullptr, arrays.thin_gains[k], arrays, worst);
      }
    }
  }
  return {largest_lane(worst.strain), largest_lane(worst.bent), smallest_lane(worst.volume)};
}

}  // namespace livegs
