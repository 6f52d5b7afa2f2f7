// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/elastic/cells/cell_batches.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "physics/elastic/cells/plate_cell.h"

namespace livegs {
namespace {

std::array<double, 8> of_corners(const LatticeCell& cell, std::span<const double> values) {
  std::array<double, 8> corners;
  for (int c = 0; c < 8; ++c) corners[c] = values[cell.nodes[c]];
  return corners;
}

// Converts to single precision. Values that are rounding errors relative to `scale` become 0; otherwise their
// products could be denormal, which is very slow.
float significant(double value, double scale) {
  return std::abs(value) > 1e-8 * scale ? static_cast<float>(value) : 0.0f;
}

bool movable(const std::array<double, 8>& inverse_masses) {
  return std::ranges::any_of(inverse_masses, [](double w) { return w > 0.0; });
}

// Whether the cell is full, of the body's own material only, and between nodes of equal mass.
bool full(const LatticeCell& cell, const std::array<double, 8>& inverse_masses, double full_inverse_mass) {
  if (cell.materials.size() > 1 || (cell.materials.size() == 1 && cell.materials[0].material != 0))
    return false;
  const double same = 1e-6;  // relative, for equal masses, centroids and spreads
  if (cell.centroid.cwiseAbs().maxCoeff() > same || (cell.spread.array() - 1.0).abs().maxCoeff() > same)
    return false;
  return std::ranges::all_of(
      inverse_masses, [&](double w) { return std::abs(w - full_inverse_mass) <= same * full_inverse_mass; });
}

// Eight lanes on the spare nodes: cells at rest without mass or stiffness.
template <class Cells>
Cells spare_cells(uint32_t spare_nodes) {
  Cells cells;
  std::memset(static_cast<void*>(&cells), 0, sizeof cells);
  for (uint32_t c = 0; c < 8; ++c) {
    for (auto& node : cells.nodes[c]) node = spare_nodes + c;
  }
  cells.rotation[0] = all_lanes(1.0f);
  return cells;
}

// Appends a cell to the batches of one kind and colour.
template <class Cells>
CellPlace place(std::vector<Cells>& eights, size_t colour_begin, uint32_t& used, uint32_t spare_nodes,
                CellPlace::Kind kind, const LatticeCell& cell, const Eigen::Quaterniond& rotation) {
  const uint32_t lane = used % 8;
  if (lane == 0) eights.push_back(spare_cells<Cells>(spare_nodes));
  const auto index = static_cast<uint32_t>(colour_begin + used / 8);
  ++used;
  Cells& eight = eights[index];
  for (int c = 0; c < 8; ++c) eight.nodes[c][lane] = cell.nodes[c];
  const double q[4] = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
  for (int k = 0; k < 4; ++k) eight.rotation[k][lane] = static_cast<float>(q[k]);
  return {kind, static_cast<uint8_t>(lane), index};
}

// Inverse mass of the heaviest nodes: those inside a full body.
double heaviest_inverse_mass(std::span<const double> inverse_masses) {
  double least = 0.0;
  for (const double w : inverse_masses) {
    if (w > 0.0 && (least == 0.0 || w < least)) least = w;
  }
  return least;
}

}  // namespace

Eigen::Quaterniond CellBatches::rotation(size_t cell) const {
  const CellPlace& at = places[cell];
  if (at.kind == CellPlace::Kind::Held) return Eigen::Quaterniond::Identity();
  const Lanes(&q)[4] = at.kind == CellPlace::Kind::Full  ? full[at.index].rotation
                       : at.kind == CellPlace::Kind::Cut ? cut[at.index].rotation
                                                         : thin[at.index].rotation;
  return Eigen::Quaterniond(q[0][at.lane], q[1][at.lane], q[2][at.lane], q[3][at.lane]).normalized();
}

void CellBatches::set_rotations(const Eigen::Quaterniond& rotation) {
  const double q[4] = {rotation.w(), rotation.x(), rotation.y(), rotation.z()};
  for (const CellPlace& at : places) {
    if (at.kind == CellPlace::Kind::Held) continue;
    Lanes(&turned)[4] = at.kind == CellPlace::Kind::Full  ? full[at.index].rotation
                        : at.kind == CellPlace::Kind::Cut ? cut[at.index].rotation
                                                          : thin[at.index].rotation;
    for (int k = 0; k < 4; ++k) turned[k][at.lane] = static_cast<float>(q[k]);
  }
}

size_t CellBatches::bytes() const {
  return full.capacity() * sizeof(FullCells) + cut.capacity() * sizeof(CutCells) +
         thin.capacity() * sizeof(ThinCells) + places.capacity() * sizeof(CellPlace);
}

IsotropicMaterial CellMaterials::of(const LatticeCell& cell) const {
  if (cell.materials.size() < 2) return materials[cell.materials.empty() ? 0 : cell.materials[0].material];
  double shear = 0.0, bulk = 0.0;
  for (const MaterialShare& share : cell.materials) {
    const IsotropicMaterial& one = materials[share.material];
    shear += share.part * one.shear_modulus_pa();
    bulk += share.part * one.youngs_modulus_pa / (3.0 * (1.0 - 2.0 * one.poisson_ratio));
  }
  const double youngs = 9.0 * bulk * shear / (3.0 * bulk + shear);
  return {youngs, std::max(0.0, youngs / (2.0 * shear) - 1.0)};
}

CellBatches make_cell_batches(const Lattice& lattice, std::span<const double> inverse_masses,
                              std::span<const Eigen::Quaterniond> rotations, uint32_t spare_nodes,
                              bool may_be_full, bool may_be_thin) {
  CellBatches result;
  result.places.resize(lattice.cells.size());
  result.paired = std::ranges::all_of(lattice.cells, [](const LatticeCell& cell) {
    for (int c = 0; c < 8; c += 2) {
      if (cell.nodes[c + 1] != cell.nodes[c] + 1) return false;
    }
    return true;
  });
  const double full_inverse_mass = heaviest_inverse_mass(inverse_masses);
  static_assert(std::size(CellColours{}.full_begin) == kLatticeColours + 1);
  for (int colour = 0; colour < kLatticeColours; ++colour) {
    result.colours.full_begin[colour] = result.full.size();
    result.colours.cut_begin[colour] = result.cut.size();
    result.colours.thin_begin[colour] = result.thin.size();
    uint32_t full_used = 0, cut_used = 0, thin_used = 0;
    for (uint32_t i = lattice.colour_begin[colour]; i < lattice.colour_begin[colour + 1]; ++i) {
      const LatticeCell& cell = lattice.cells[i];
      const std::array<double, 8> inverse = of_corners(cell, inverse_masses);
      if (!movable(inverse)) continue;
      if (may_be_thin && cell.thin) {
        const CellPlace at = place(result.thin, result.colours.thin_begin[colour], thin_used, spare_nodes,
                                   CellPlace::Kind::Thin, cell, rotations[i]);
        result.places[i] = at;
        ThinCells& eight = result.thin[at.index];
        for (int d = 0; d < 3; ++d) eight.centroid[d][at.lane] = significant(cell.centroid[d], 1.0);
        eight.mobility[at.lane] =
            static_cast<float>(make_cell_block(cell, lattice.cell_width_m, inverse).mobility.trace());
        eight.fold[at.lane] = static_cast<float>(thin_cell_fold(cell, lattice.cell_width_m));
        continue;
      }
      if (may_be_full && full(cell, inverse, full_inverse_mass)) {
        result.places[i] = place(result.full, result.colours.full_begin[colour], full_used, spare_nodes,
                                 CellPlace::Kind::Full, cell, rotations[i]);
        continue;
      }
      const CellPlace at = place(result.cut, result.colours.cut_begin[colour], cut_used, spare_nodes,
                                 CellPlace::Kind::Cut, cell, rotations[i]);
      result.places[i] = at;
      CutCells& eight = result.cut[at.index];
      const CellBlock block = make_cell_block(cell, lattice.cell_width_m, inverse);
      const Eigen::Matrix3d& g = block.mobility;
      const double mobility[6] = {g(0, 0), g(1, 1), g(2, 2), g(1, 2), g(0, 2), g(0, 1)};
      for (int k = 0; k < 6; ++k) eight.mobility[k][at.lane] = significant(mobility[k], g.trace());
      const double coupling = std::sqrt(block.largest_inverse_mass * g.trace());
      for (int d = 0; d < 3; ++d) {
        eight.centroid[d][at.lane] = significant(cell.centroid[d], 1.0);
        for (int j = 0; j < kModeCount; ++j) {
          eight.mode_coupling[j][d][at.lane] = significant(block.mode_coupling[j][d], coupling);
        }
      }
    }
  }
  result.colours.full_begin[kLatticeColours] = result.full.size();
  result.colours.cut_begin[kLatticeColours] = result.cut.size();
  result.colours.thin_begin[kLatticeColours] = result.thin.size();
  return result;
}

static void set_cell_gains(GaussSeidelGains& gains, const Lattice& lattice, const CellBatches& batches,
                           size_t index, std::span<const double> inverse_masses,
                           const CellMaterials& materials, bool compensate, double step_s) {
  const CellPlace& at = batches.places[index];
  if (at.kind == CellPlace::Kind::Held) return;
  const LatticeCell& cell = lattice.cells[index];
  const std::array<double, 8> inverse = of_corners(cell, inverse_masses);
  const CellBlock block = make_cell_block(cell, lattice.cell_width_m, inverse);
  if (at.kind == CellPlace::Kind::Thin) {
    const IsotropicMaterial material = materials.of(cell);
    const Matrix6 modulus =
        compensate ? compensated_modulus(cell, block, material, step_s) : strain_modulus(material);
    const Matrix18 gain = thin_cell_gain(thin_cell_stiffness(cell, lattice.cell_width_m, material, modulus),
                                         thin_cell_mobility(cell, lattice.cell_width_m, inverse), step_s);
    for (int row = 0, k = 0; row < 18; ++row) {
      for (int column = row; column < 18; ++column, ++k) {
        gains.thin[at.index].gain[k][at.lane] =
            significant(gain(row, column), std::sqrt(gain(row, row) * gain(column, column)));
      }
    }
    return;
  }
  const CellGains own =
      make_cell_gains(cell, block, lattice.cell_width_m, materials.of(cell), step_s, compensate);
  if (at.kind == CellPlace::Kind::Full) {
    gains.full.mobility = static_cast<float>(block.mobility(0, 0));
    gains.full.shear = static_cast<float>(own.shear(0, 0));
    gains.full.volume_compliance = static_cast<float>(own.volume_compliance);
    for (int j = 0; j < kModeCount; ++j) {
      for (int d = 0; d < 3; ++d) gains.full.mode[j][d] = static_cast<float>(own.mode[j][d]);
    }
    return;
  }
  CutGains& eight = gains.cut[at.index];
  for (int row = 0, k = 0; row < 6; ++row) {
    for (int column = row; column < 6; ++column, ++k) {
      eight.shear[k][at.lane] = significant(own.shear(row, column), own.shear.trace());
    }
  }
  eight.volume_compliance[at.lane] = static_cast<float>(own.volume_compliance);
  for (int j = 0; j < kModeCount; ++j) {
    for (int d = 0; d < 3; ++d) eight.mode[j][d][at.lane] = static_cast<float>(own.mode[j][d]);
  }
}

GaussSeidelGains make_gauss_seidel_gains(const Lattice& lattice, const CellBatches& batches,
                                         std::span<const double> inverse_masses,
                                         const CellMaterials& materials, bool compensate, double step_s) {
  GaussSeidelGains result;
  CutGains nothing;
  std::memset(static_cast<void*>(&nothing), 0, sizeof nothing);
  nothing.volume_compliance = all_lanes(1.0f);
  result.cut.assign(batches.cut.size(), nothing);
  result.thin.resize(batches.thin.size());
  result.full.volume_compliance = 1.0f;
  bool full_known = false;  // all full cells share one set of gains
  for (size_t i = 0; i < lattice.cells.size(); ++i) {
    const bool full = batches.places[i].kind == CellPlace::Kind::Full;
    if (full && full_known) continue;
    full_known = full_known || full;
    set_cell_gains(result, lattice, batches, i, inverse_masses, materials, compensate, step_s);
  }
  return result;
}

}  // namespace livegs
