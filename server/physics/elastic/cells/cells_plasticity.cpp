// SPDX-License-Identifier: GPL-3.0-or-later
// Plastic flow, once per frame: return mapping (return_mapping.h) of each cell's mean deformation, and
// likewise of its bending and twisting modes. Without the modes, a sheet of one cell's thickness would
// recover from every dent.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/plate_cell.h"
#include "physics/material/return_mapping.h"

namespace livegs::cells {
namespace {

bool none_flowed(const std::array<Vector3d, kModeCount>& modes) {
  return std::ranges::all_of(modes, [](const Vector3d& mode) { return mode.isZero(0.0); });
}

}  // namespace

// F and the mode amplitudes of a cell, in world axes.
CellsBody::CellShape CellsBody::unturned_shape_of(size_t index) const {
  const LatticeCell& cell = lattice_.cells[index];
  const auto gradients = trilinear_gradients(cell.centroid, lattice_.cell_width_m);
  CellShape shape;
  shape.f.setZero();
  shape.modes.fill(Vector3d::Zero());
  for (int c = 0; c < 8; ++c) {
    const Vector3d x = nodes_.position_m(cell.nodes[c]);
    shape.f += x * gradients[c].transpose();
    for (int j = 0; j < kModeCount; ++j) shape.modes[j] += 0.125 * mode_sign(j, c) * x;
  }
  return shape;
}

// F and the mode amplitudes, the latter in the cell's rotated frame.
CellsBody::CellShape CellsBody::shape_of(size_t index) const {
  CellShape shape = unturned_shape_of(index);
  turn(index, shape);
  return shape;
}

void CellsBody::turn(size_t index, CellShape& shape) const {
  shape.rotation = extract_rotation(shape.f, batches_.rotation(index)).toRotationMatrix();
  for (Vector3d& mode : shape.modes) mode = shape.rotation.transpose() * mode;
}

void CellsBody::flow() {
  if (recovery_.recovering) return;
  if (*std::max_element(materials_.plasticities.begin(), materials_.plasticities.end()) <= 0.0) return;
  YieldSurface surface;  // of the last cell, cached: most bodies have one material
  double surface_plasticity = NAN, surface_poisson_ratio = NAN;
  for (size_t i = 0; i < lattice_.cells.size(); ++i) {
    const LatticeCell& cell = lattice_.cells[i];
    double plasticity = 0.0;
    for (const MaterialShare& share : cell.materials)
      plasticity += share.part * materials_.plasticities[share.material];
    if (plasticity <= 0.0) continue;
    const IsotropicMaterial material = materials_.cells.of(cell);
    const Matrix3d before = plastic_.parts.empty() ? Matrix3d::Identity() : plastic_.parts[i];
    if (plasticity != surface_plasticity || material.poisson_ratio != surface_poisson_ratio) {
      surface = yield_surface(plasticity, material.poisson_ratio);
      surface_plasticity = plasticity;
      surface_poisson_ratio = material.poisson_ratio;
    }
    // A mode of amplitude q strains the faces of a cell by 4 q / a, and the faces of a thin sheet in the cell
    // by less.
    const bool thin = batches_.places[i].kind == CellPlace::Kind::Thin;
    const double width_m = lattice_.cell_width_m, yield = 1.0 - plasticity;
    const double thickness_m = thin ? std::sqrt(12.0 * cell.thin->variance_m2[0]) : width_m;
    const double per_m = 4.0 / width_m * (thickness_m / width_m);

    // Cheap test, because most cells are far from yielding: |U - I| <= |U² - I|.
    CellShape shape = unturned_shape_of(i);
    const bool fresh = plastic_.parts.empty() ||
                       (plastic_.parts[i] == Matrix3d::Identity() && none_flowed(plastic_.modes[i]));
    if (fresh && (shape.f.transpose() * shape.f - Matrix3d::Identity()).norm() <= surface.radius &&
        std::ranges::all_of(shape.modes,
                            [&](const Vector3d& mode) { return per_m * mode.norm() <= yield; })) {
      continue;
    }
    turn(i, shape);
    const PlasticFlow flowed = flow_plastically(surface, shape.f * before.inverse(), before);
    std::array<Vector3d, kModeCount> rest;
    bool bent = false;
    for (int j = 0; j < kModeCount; ++j) {
      rest[j] = plastic_.modes.empty() ? Vector3d::Zero() : plastic_.modes[i][j];
      const Vector3d elastic = shape.modes[j] - rest[j];
      const double strain = per_m * elastic.norm();
      if (strain <= yield * (1.0 + 1e-6) || shape.f.determinant() < 0.05) continue;
      Vector3d reached = rest[j] + (1.0 - yield / strain) * elastic;
      const double size = per_m * reached.norm();
      if (size > plasticity) reached *= plasticity / size;
      bent = bent || (reached - rest[j]).norm() * per_m > 1e-9;
      rest[j] = reached;
    }
    if (!flowed.flowed && !bent) continue;
    begin_plastic();
    // If strain and bending are coupled, one can flow at the cost of the other. Flow that would increase the
    // stored energy is rejected.
    const double stored = energy_of(i, shape);
    const std::array<Vector3d, kModeCount> rest_before = plastic_.modes[i];
    double work = 0.0;
    for (const auto& [strain_flows, modes_flow] : {std::pair(true, true), {true, false}, {false, true}}) {
      plastic_.parts[i] = strain_flows ? flowed.plastic_part : before;
      plastic_.modes[i] = modes_flow ? rest : rest_before;
      work = stored - energy_of(i, shape);
      if (work >= 0.0 || without(Mechanism::FlowEnergyCheck)) break;
    }
    if (work < 0.0 && !without(Mechanism::FlowEnergyCheck)) {
      plastic_.modes[i] = rest_before;
      continue;
    }
    plastic_.work_j += work;
    set_plastic_lanes(i);
  }
}

// From the first flow on, every cell has its own constants.
void CellsBody::begin_plastic() {
  if (!plastic_.parts.empty()) return;
  plastic_.parts.assign(lattice_.cells.size(), Matrix3d::Identity());
  plastic_.modes.assign(lattice_.cells.size(),
                        {Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero(), Vector3d::Zero()});
  const double h = gains_.last_step_s;
  rebuild_cells();
  gains_.last_step_s = h;
}

// Discards plastic flow caused by a tangled state; it is unrelated to the intended shape.
void CellsBody::discard_plastic_flow() {
  plastic_.parts.clear();
  plastic_.modes.clear();
  plastic_.cut.clear();
  plastic_.thin.clear();
  const double h = gains_.last_step_s;
  rebuild_cells();
  gains_.last_step_s = h;
}

void CellsBody::set_all_plastic() {
  PlasticCells whole{};
  for (int k = 0; k < 3; ++k) whole.part[k] = all_lanes(1.0f);
  plastic_.cut.assign(batches_.cut.size(), whole);
  plastic_.thin.assign(batches_.thin.size(), whole);
  for (size_t i = 0; i < lattice_.cells.size(); ++i) set_plastic_lanes(i);
}

void CellsBody::set_plastic_lanes(size_t index) {
  const CellPlace& at = batches_.places[index];
  if (at.kind != CellPlace::Kind::Cut && at.kind != CellPlace::Kind::Thin) return;
  PlasticCells& eight = at.kind == CellPlace::Kind::Cut ? plastic_.cut[at.index] : plastic_.thin[at.index];
  const Vector6 part = mandel(plastic_.parts[index]);
  for (int k = 0; k < 6; ++k) eight.part[k][at.lane] = static_cast<float>(part[k]);
  for (int j = 0; j < kModeCount; ++j) {
    for (int d = 0; d < 3; ++d)
      eight.mode_rest[j][d][at.lane] = static_cast<float>(plastic_.modes[index][j][d]);
  }
}

double CellsBody::energy_of(size_t index, const CellShape& shape) const {
  Matrix3d rest = Matrix3d::Identity();
  std::array<Vector3d, kModeCount> modes = shape.modes;
  if (!plastic_.parts.empty()) {
    rest = plastic_.parts[index];
    for (int j = 0; j < kModeCount; ++j) modes[j] -= plastic_.modes[index][j];
  }
  const LatticeCell& cell = lattice_.cells[index];
  const Matrix3d stretch = shape.rotation.transpose() * shape.f;
  if (options_.thin && cell.thin) {
    const IsotropicMaterial material = materials_.cells.of(cell);
    Vector18 measures;
    measures.head<6>() = mandel(0.5 * (stretch + stretch.transpose()) - rest);
    for (int j = 0; j < kModeCount; ++j) measures.segment<3>(6 + 3 * j) = modes[j];
    return 0.5 *
           measures.dot(thin_cell_stiffness(cell, lattice_.cell_width_m, material, strain_modulus(material)) *
                        measures);
  }
  return cell_energy(cell, lattice_.cell_width_m, materials_.cells.of(cell),
                     0.5 * (stretch + stretch.transpose()) - rest, shape.f.determinant(), modes);
}

}  // namespace livegs::cells
