// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/cells/kernels/cell_algebra.h"
#include "physics/elastic/cells/kernels/cell_kernels.h"

namespace livegs {
namespace {

using namespace lanes;

// Loads the corner positions; returns the inverse masses of the first corner.
LIVEGS_INLINE Lanes gather(const uint32_t (&nodes)[8][8], const NodeLanes* positions,
                           Lanes (&position)[3][8]) {
  Lanes inverse_mass = all_lanes(0.0f);
  for (int c = 0; c < 8; c += 2) {
    Lanes rows[8];
    for (int l = 0; l < 8; ++l) rows[l] = pair_of(positions[nodes[c][l]], positions[nodes[c + 1][l]]);
    transpose(rows);
    for (int d = 0; d < 3; ++d) {
      position[d][c] = rows[d];
      position[d][c + 1] = rows[d + 4];
    }
    if (c == 0) inverse_mass = rows[3];
  }
  return inverse_mass;
}

// `position` holds the sums by corner signs; mode(j, d) is half the stiffness over 64, because an amplitude
// is an eighth of a sum.
template <class Mode>
LIVEGS_INLINE Lanes energy_of(const Lanes (&kept)[4], const Matrix& f, const Lanes (&position)[3][8],
                              Lanes shear_j, Lanes half_lambda_j, const Mode& mode) {
  Lanes rotation[4] = {kept[0], kept[1], kept[2], kept[3]};
  Matrix r, m;
  follow_rotation(rotation, f, r, m);
  Symmetric lack;
  Lanes volume;
  strain_of(m, lack, volume);
  const Lanes change = volume - all_lanes(1.0f);
  Lanes energy = shear_j * dot(lack, lack) + half_lambda_j * change * change;
  for (int d = 0; d < 3; ++d) {
    for (int j = 0; j < 4; ++j) {
      const int k = kModeIndex[j];
      const Lanes turned =
          r.m[0][d] * position[0][k] + r.m[1][d] * position[1][k] + r.m[2][d] * position[2][k];
      energy += mode(j, d) * turned * turned;
    }
  }
  return energy;
}

// Energy of each of the eight cells; 0 in unused lanes.
LIVEGS_INLINE Lanes energy_of_full(const FullCells& cells, const NodeLanes* positions,
                                   const FullModuli& moduli, Lanes q4) {
  Lanes position[3][8];
  const Lanes inverse_mass = gather(cells.nodes, positions, position);
  const Matrix f = full_gradient(q4, position);
  const Lanes energy =
      energy_of(cells.rotation, f, position, all_lanes(moduli.shear_j), all_lanes(0.5f * moduli.lambda_j),
                [&](int j, int d) { return all_lanes(0.5f / 64.0f * moduli.mode_n_m[j][d]); });
  return inverse_mass > all_lanes(0.0f) ? energy : all_lanes(0.0f);
}

LIVEGS_INLINE Lanes energy_of_cut(const CutCells& cells, const NodeLanes* positions, const CutModuli& moduli,
                                  Lanes q4) {
  Lanes position[3][8];
  gather(cells.nodes, positions, position);
  const Matrix f = gradient_at(cells.centroid, q4, position);
  const Lanes energy =
      energy_of(cells.rotation, f, position, moduli.shear_j, all_lanes(0.5f) * moduli.lambda_j,
                [&](int j, int d) { return all_lanes(0.5f / 64.0f) * moduli.mode_n_m[j][d]; });
  return moduli.shear_j > all_lanes(0.0f) ? energy : all_lanes(0.0f);
}

double add_lanes(double sum, const Lanes& energy) {
  for (int l = 0; l < 8; ++l) sum += static_cast<double>(energy[l]);
  return sum;
}

}  // namespace

double full_cell_energy(const FullCells* begin, const FullCells* end, const NodeLanes* positions,
                        const FullModuli& moduli, float inverse_four_widths) {
  double sum = 0.0;
  for (const FullCells* cells = begin; cells != end; ++cells) {
    sum = add_lanes(sum, energy_of_full(*cells, positions, moduli, all_lanes(inverse_four_widths)));
  }
  return sum;
}

double cut_cell_energy(const CutCells& cells, const NodeLanes* positions, const CutModuli& moduli,
                       float inverse_four_widths) {
  return add_lanes(0.0, energy_of_cut(cells, positions, moduli, all_lanes(inverse_four_widths)));
}

}  // namespace livegs
