// SPDX-License-Identifier: GPL-3.0-or-later
// Energy limiter for strains beyond the range of the sweep's compensation, where a body can gain energy: limp
// sheets that spin faster than their wave speed, thin parts that are pulled hard. The total energy may only
// increase by the work of hands and moving bodies; static bodies do no work. Any excess is removed from the
// node velocities relative to the rigid motion, which preserves momentum and angular momentum. The check runs
// once per frame, only while a cell is badly strained. It costs about half a substep.
#include <algorithm>
#include <cmath>

#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"

namespace livegs::cells {
namespace {

// Tolerated gain relative to the energy without that of flight. With a larger tolerance badly strained bodies
// gain energy.
constexpr double kMaxGain = 0.003;
// Limits of a plausible energy, beyond which the state is lost. Relative to E V (strains of about a hundred
// everywhere), and relative to the energy of a fall over the body's own length plus the energy of flight.
constexpr double kMaxStrainEnergyRatio = 1e5, kMaxFallEnergyRatio = 1e3;

// Passes the moduli of a cell (cell_energy) to put(shear, lambda, modes).
template <class Put>
void put_moduli(const LatticeCell& cell, double width_m, const IsotropicMaterial& material, const Put& put) {
  put(static_cast<float>(cell.volume_m3 * material.shear_modulus_pa()),
      static_cast<float>(cell.volume_m3 * material.lame_lambda_pa()),
      mode_stiffness(cell, width_m, material));
}

}  // namespace

double CellsBody::elastic_f32_j() const {
  // With plastic flow no cell is full, and cut cells have individual rest strains.
  std::vector<CutModuli> cut(plastic_.parts.empty() ? batches_.cut.size() : 0, CutModuli{});
  double sum = 0.0;
  size_t a_full_one = lattice_.cells.size();
  for (size_t i = 0; i < lattice_.cells.size(); ++i) {
    const CellPlace& at = batches_.places[i];
    const LatticeCell& cell = lattice_.cells[i];
    if (at.kind == CellPlace::Kind::Full) {
      a_full_one = i;
    } else if (at.kind == CellPlace::Kind::Cut && !cut.empty()) {
      put_moduli(cell, lattice_.cell_width_m, materials_.cells.of(cell),
                 [&](float shear_j, float lambda_j, const auto& modes) {
                   CutModuli& eight = cut[at.index];
                   eight.shear_j[at.lane] = shear_j;
                   eight.lambda_j[at.lane] = lambda_j;
                   for (int j = 0; j < kModeCount; ++j) {
                     for (int d = 0; d < 3; ++d)
                       eight.mode_n_m[j][d][at.lane] = static_cast<float>(modes[j][d]);
                   }
                 });
    } else {
      sum += energy_of(i, shape_of(i));
    }
  }
  const float inverse_four_widths = static_cast<float>(0.25 / lattice_.cell_width_m);
  for (size_t k = 0; k < cut.size(); ++k) {
    sum += cut_cell_energy(batches_.cut[k], nodes_.positions(), cut[k], inverse_four_widths);
  }
  if (a_full_one == lattice_.cells.size()) return sum;
  FullModuli full;
  const LatticeCell& cell = lattice_.cells[a_full_one];
  put_moduli(cell, lattice_.cell_width_m, materials_.cells.of(cell),
             [&](float shear_j, float lambda_j, const auto& modes) {
               full.shear_j = shear_j;
               full.lambda_j = lambda_j;
               for (int j = 0; j < kModeCount; ++j) {
                 for (int d = 0; d < 3; ++d) full.mode_n_m[j][d] = static_cast<float>(modes[j][d]);
               }
             });
  const FullCells* cells = batches_.full.data();
  return sum +
         full_cell_energy(cells, cells + batches_.full.size(), nodes_.positions(), full, inverse_four_widths);
}

// Runs once per frame, before other changes between frames. False: the state is lost.
bool CellsBody::limit_energy() {
  if (without(Mechanism::EnergyLimiter)) return true;
  const double work_j = std::exchange(limiter_.work_j, 0.0);
  const bool unknown =
      rest_.driven || holding_.moved || recovery_.recovering || is_separating() || !loads_.regions.empty();
  // Above a Courant number of 1 the computed energy is not meaningful, because the body shows only a small
  // part of its modulus. Only studies take such steps.
  if (accuracy_.resolution.courant > 1.0 ||
      std::max(step_.strain_squared, step_.bent_squared) < kStrainedSquared) {
    limiter_.limit_j.reset();
    return true;
  }
  const double stored_j = elastic_f32_j(),
               flight_j = free() ? 0.5 * ledger_.motion.momentum.squaredNorm() / mass_kg_ : 0.0;
  const double inner_j = std::max(0.0, step_.kinetic_j - flight_j) + stored_j;
  const double fall_j = mass_kg_ * step_.gravity_m_s2 * reach_m_ + flight_j;
  if (inner_j > kMaxStrainEnergyRatio * materials_.cells.materials[0].youngs_modulus_pa * volume_m3_ +
                    kMaxFallEnergyRatio * fall_j)
    return false;
  const double energy_j = step_.kinetic_j + stored_j - mass_kg_ * step_.gravity.dot(centre_m());
  const double energy_limit_j =
      limiter_.limit_j && !unknown ? std::min(*limiter_.limit_j + work_j, energy_j) : energy_j;
  limiter_.limit_j = energy_limit_j;
  const double gained_j = energy_j - energy_limit_j;
  if (gained_j <= kMaxGain * inner_j) return true;

  const Vector3d velocity = free() ? ledger_.motion.velocity_m_s() : Vector3d::Zero();
  const Vector3d spin = free() ? ledger_.motion.angular_velocity_rad_s() : Vector3d::Zero();
  std::vector<Vector3d> deviation(nodes_.count());
  double deviation_j = 0.0;
  for (size_t i = 0; i < deviation.size(); ++i) {
    if (inverse_masses_[i] == 0.0) continue;
    deviation[i] =
        nodes_.velocity_m_s(i) - velocity - spin.cross(nodes_.position_m(i) - ledger_.motion.centre_m);
    deviation_j += 0.5 * masses_kg_[i] * deviation[i].squaredNorm();
  }
  if (!(deviation_j > 0.0)) return true;
  const double taken = 1.0 - std::sqrt(1.0 - std::min(1.0, gained_j / deviation_j));
  for (size_t i = 0; i < deviation.size(); ++i) {
    if (inverse_masses_[i] != 0.0) nodes_.change_velocities(i, -taken * deviation[i]);
  }
  return true;
}

}  // namespace livegs::cells
