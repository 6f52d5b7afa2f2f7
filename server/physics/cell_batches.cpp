// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstring>
#include <limits>

#include "physics/cell_sweep.h"

namespace livegs {
namespace {

constexpr uint32_t kNoPlace = std::numeric_limits<uint32_t>::max();

CellBatch empty_batch(double cell_width, uint32_t spare_node) {
  CellBatch batch;
  std::memset(static_cast<void*>(&batch), 0, sizeof batch);
  for (auto& corner : batch.nodes) corner.fill(spare_node);
  batch.rotation[0] = all_lanes(1.0);
  batch.inverse_four_widths = all_lanes(0.25 / cell_width);
  return batch;
}

bool movable(const LatticeCell& cell, std::span<const double> inverse_masses) {
  for (const uint32_t node : cell.nodes) {
    if (inverse_masses[node] > 0.0) return true;
  }
  return false;
}

}  // namespace

Eigen::Quaterniond CellBatches::rotation(size_t cell) const {
  if (places[cell] == kNoPlace) return Eigen::Quaterniond::Identity();
  const CellBatch& batch = batches[places[cell] / 4];
  const int place = static_cast<int>(places[cell] % 4);
  return {batch.rotation[0][place], batch.rotation[1][place], batch.rotation[2][place], batch.rotation[3][place]};
}

CellBatches make_cell_batches(const Lattice& lattice, std::span<const CellBlock> blocks,
                              std::span<const double> inverse_masses, const Eigen::Quaterniond& rotation,
                              uint32_t spare_node) {
  CellBatches result;
  result.places.assign(lattice.cells.size(), kNoPlace);
  for (int colour = 0; colour < 8; ++colour) {
    int place = 4;  // a colour starts a batch of its own
    for (uint32_t i = lattice.colour_begin[colour]; i < lattice.colour_begin[colour + 1]; ++i) {
      const LatticeCell& cell = lattice.cells[i];
      if (!movable(cell, inverse_masses)) continue;
      if (place == 4) {
        result.batches.push_back(empty_batch(lattice.cell_width_m, spare_node));
        place = 0;
      }
      CellBatch& batch = result.batches.back();
      result.places[i] = static_cast<uint32_t>(4 * (result.batches.size() - 1) + place);
      for (int c = 0; c < 8; ++c) batch.nodes[c][place] = cell.nodes[c];
      const Eigen::Matrix3d& g = blocks[i].mobility;
      const double mobility[6] = {g(0, 0), g(1, 1), g(2, 2), g(1, 2), g(0, 2), g(0, 1)};
      for (int k = 0; k < 6; ++k) batch.mobility[k][place] = mobility[k];
      for (int d = 0; d < 3; ++d) {
        batch.centroid[d][place] = cell.centroid[d];
        for (int j = 0; j < kModeCount; ++j) batch.mode_coupling[j][d][place] = blocks[i].mode_coupling[j][d];
      }
      batch.rotation[0][place] = rotation.w();
      batch.rotation[1][place] = rotation.x();
      batch.rotation[2][place] = rotation.y();
      batch.rotation[3][place] = rotation.z();
      ++place;
    }
  }
  return result;
}

std::vector<BatchGains> make_batch_gains(const CellBatches& batches, std::span<const CellGains> gains) {
  BatchGains empty;
  std::memset(static_cast<void*>(&empty), 0, sizeof empty);
  empty.volume_compliance = all_lanes(1e300);
  std::vector<BatchGains> result(batches.batches.size(), empty);
  for (size_t i = 0; i < gains.size(); ++i) {
    if (batches.places[i] == kNoPlace) continue;
    BatchGains& batch = result[batches.places[i] / 4];
    const int place = static_cast<int>(batches.places[i] % 4);
    for (int row = 0, k = 0; row < 6; ++row) {
      for (int column = row; column < 6; ++column, ++k) batch.shear[k][place] = gains[i].shear(row, column);
    }
    batch.volume_compliance[place] = gains[i].volume_compliance;
    for (int j = 0; j < kModeCount; ++j) {
      for (int d = 0; d < 3; ++d) batch.mode[j][d][place] = gains[i].mode[j][d];
    }
  }
  return result;
}

}  // namespace livegs
