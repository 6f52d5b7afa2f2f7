// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/cell_algebra.h"
#include "physics/cell_kernels.h"

namespace livegs {
namespace {

using namespace lanes;

// Of the eight cells; 0 in unused places.
LIVEGS_INLINE Lanes energy_of_full(const FullCells& cells, const NodeLanes* positions, const FullModuli& moduli, Lanes q4) {
  Lanes position[3][8], inverse_mass = all_lanes(0.0f);
  for (int c = 0; c < 8; c += 2) {
    Lanes rows[8];
    for (int l = 0; l < 8; ++l) rows[l] = pair_of(positions[cells.nodes[c][l]], positions[cells.nodes[c + 1][l]]);
    transpose(rows);
    for (int d = 0; d < 3; ++d) {
      position[d][c] = rows[d];
      position[d][c + 1] = rows[d + 4];
    }
    if (c == 0) inverse_mass = rows[3];
  }
  const Matrix f = full_gradient(q4, position);
  Lanes rotation[4] = {cells.rotation[0], cells.rotation[1], cells.rotation[2], cells.rotation[3]};
  Matrix r, m;
  follow_rotation(rotation, f, r, m);
  Symmetric lack;
  Lanes volume;
  strain_of(m, lack, volume);
  const Lanes change = volume - all_lanes(1.0f);
  Lanes energy = all_lanes(moduli.shear_j) * dot(lack, lack) + all_lanes(0.5f * moduli.lambda_j) * change * change;
  for (int d = 0; d < 3; ++d) {
    for (int j = 0; j < 4; ++j) {
      const int k = kModeIndex[j];
      const Lanes turned = r.m[0][d] * position[0][k] + r.m[1][d] * position[1][k] + r.m[2][d] * position[2][k];
      energy += all_lanes(0.5f / 64.0f * moduli.mode_n_m[j][d]) * turned * turned;  // an amplitude is an eighth of a sum
    }
  }
  return inverse_mass > all_lanes(0.0f) ? energy : all_lanes(0.0f);
}

}  // namespace

double full_cell_energy(const FullCells* begin, const FullCells* end, const NodeLanes* positions, const FullModuli& moduli,
                        float inverse_four_widths) {
  double sum = 0.0;
  for (const FullCells* cells = begin; cells != end; ++cells) {
    const Lanes energy = energy_of_full(*cells, positions, moduli, all_lanes(inverse_four_widths));
    for (int l = 0; l < 8; ++l) sum += static_cast<double>(energy[l]);
  }
  return sum;
}

}  // namespace livegs
