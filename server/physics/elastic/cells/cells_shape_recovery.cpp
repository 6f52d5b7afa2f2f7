// SPDX-License-Identifier: GPL-3.0-or-later
// Recovery from tangled shapes. A body wound twice about an axis is in a true local minimum of energy: every
// cell is upright and nearly at rest, and no local rule leads out. Folded edges can be another minimum. The
// state is detected for the whole body: its best affine fit is far from a rotation, or it is strained
// although it is at rest without contact. A body in contact, or with plastic flow, is recovered only if its
// strain is extreme. Plastic flow of the tangled state is discarded. Test: elastic_recovery_test.cpp.
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/math/nearest_rotation.h"
#include "physics/ablation/ablation.h"
#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/cells/plate_cell.h"
#include "physics/material/return_mapping.h"

namespace livegs::cells {
namespace {

// det A / (|A| / sqrt 3)³: 1 for a rotation, 0 for a flat or wound state, negative for a mirrored one.
constexpr double kRecoveredDeterminant = 0.8;
// Rate of the blend to the rigid shape; doubles after each kLastingTime_s of recovery. Most tangles resolve
// on their own within that time.
constexpr double kBlendRate_per_s = 12.0;
constexpr double kMaxEnergyGain = 1.5;              // per frame of recovery, relative to the elastic energy
constexpr double kMinRecoveryStrainSquared = 0.01;  // |S - I|² of the worst cell
constexpr double kMinOverstrainedFraction = 0.02;   // of the volume; excludes loose ends of leaves
constexpr double kMaxSag = 0.05;                    // strain by the body's own weight
// Relative to E eps A, the force of its strain; a smaller load cannot hold the shape.
constexpr double kMinHoldingForce = 0.01;
constexpr double kSettledEnergyRatio = 0.02;  // kinetic energy of the deviation over elastic energy

double normalised_determinant(const Matrix3d& a) {
  const double size = a.norm() / std::sqrt(3.0);
  return size > 0.0 ? a.determinant() / (size * size * size) : 0.0;
}

}  // namespace

// Volume fraction of the cells with a strain of order one.
double CellsBody::overstrained_volume_fraction() const {
  double overstrained_m3 = 0.0;
  for (size_t i = 0; i < lattice_.cells.size(); ++i) {
    if (batches_.places[i].kind == CellPlace::Kind::Held) continue;
    const CellShape shape = shape_of(i);
    const Matrix3d stretch = shape.rotation.transpose() * shape.f;
    const bool flowed = !plastic_.parts.empty();
    // A fold leaves no strain at the centroid, so bending is included.
    const double fold = batches_.places[i].kind == CellPlace::Kind::Thin
                            ? thin_cell_fold(lattice_.cells[i], lattice_.cell_width_m)
                            : 16.0 / (lattice_.cell_width_m * lattice_.cell_width_m);
    double squared =
        (0.5 * (stretch + stretch.transpose()) - (flowed ? plastic_.parts[i] : Matrix3d::Identity()))
            .squaredNorm();
    for (int j = 0; j < kModeCount; ++j) {
      const Vector3d bent = flowed ? Vector3d(shape.modes[j] - plastic_.modes[i][j]) : shape.modes[j];
      squared += fold * bent.squaredNorm();
    }
    if (squared > kOverstrainedSquared) overstrained_m3 += lattice_.cells[i].volume_m3;
  }
  return overstrained_m3 / volume_m3_;
}

// Mean thickness of the sheets and cords; the smallest side of a body without any.
double CellsBody::thickness_m() const {
  double thin_m3 = 0.0, sum = 0.0;
  for (const LatticeCell& cell : lattice_.cells) {
    if (!cell.thin) continue;
    thin_m3 += cell.volume_m3;
    sum += cell.volume_m3 * std::sqrt(12.0 * cell.thin->variance_m2.minCoeff());
  }
  return thin_m3 > 0.0 ? sum / thin_m3 : size_m().minCoeff();
}

void CellsBody::recover_shape(double frame_s) {
  if (!recovery_.degenerate || without(Mechanism::ShapeRecovery)) return;
  // No recovery under load or sag: the strain is then legitimate.
  const double youngs_modulus_pa = materials_.cells.materials[0].youngs_modulus_pa,
               weight_n = mass_kg_ * step_.gravity_m_s2;
  const double length_m = size_m().norm();
  const double sag = materials_.densities_kg_m3[0] * step_.gravity_m_s2 * length_m / youngs_modulus_pa;
  const double area_m2 = volume_m3_ / size_m().maxCoeff();
  const double holding_n =
      std::max(weight_n, kMinHoldingForce * youngs_modulus_pa * std::sqrt(step_.bent_squared) * area_m2);
  const bool pressed = step_.touching && (loads_.carried_n > holding_n || sag > kMaxSag),
             flowed = !plastic_.parts.empty();
  const bool alone = free() && !pressed && !rest_.forced && !is_separating() && loads_.regions.empty();
  if (!alone) {
    recovery_.degenerate_s = 0.0;
    recovery_.recovering = false;  // otherwise plastic flow would stay off while a hand holds the body
    return;
  }
  const Vector3d rest_centre = rest_centre_m();
  Matrix3d match = Matrix3d::Zero(), rest = Matrix3d::Zero();
  for (size_t i = 0; i < masses_kg_.size(); ++i) {
    const Vector3d r = lattice_.node_position_m(i) - rest_centre;
    match += masses_kg_[i] * (nodes_.position_m(i) - ledger_.motion.centre_m) * r.transpose();
    rest += masses_kg_[i] * r * r.transpose();
  }
  const Matrix3d fit = match * rest.inverse();
  if (!fit.allFinite()) return;
  const double upright = normalised_determinant(fit);
  // Spin alone strains a body by rho (omega L)² / E, and by a factor L / t more in bending.
  const double wave_squared = youngs_modulus_pa / materials_.densities_kg_m3[0],
               slender = length_m / thickness_m();
  const double spun =
      std::pow(ledger_.motion.angular_velocity_rad_s().norm() * reach_m_, 2) / wave_squared * slender;
  // A limp body in contact takes any shape under its weight, so its uprightness is not used.
  const bool limp = step_.touching && sag * slender * slender > kMaxSag;
  const bool wild = step_.touching || flowed;
  const bool strained =
      step_.bent_squared > (wild ? kOverstrainedSquared : kMinRecoveryStrainSquared) + 4.0 * spun * spun &&
      (!wild || overstrained_volume_fraction() > kMinOverstrainedFraction);
  const bool recovered = (limp || upright > kRecoveredDeterminant) && !strained;
  if (!recovery_.recovering) {
    if (recovered) recovery_.degenerate = false;
    const bool settled = strained && 0.5 * mass_kg_ * step_.deviation_m_s * step_.deviation_m_s <
                                         kSettledEnergyRatio * elastic_f32_j();
    // A tangle that does not come to rest counts half: first-order steps should have calmed it by then.
    const double weight = (!limp && upright < kMinVolumeRatio) || settled ? 1.0
                          : strained && (wild || step_.strained)          ? 0.5
                                                                          : -1.0;
    recovery_.degenerate_s = std::max(0.0, recovery_.degenerate_s + weight * frame_s);
    recovery_.recovering = recovery_.degenerate_s > kLastingTime_s;
  }
  if (!recovery_.recovering) return;
  if (recovered) {
    recovery_.recovering = false;
    recovery_.degenerate_s = 0.0;
    return;
  }
  // Blends positions to the rigid shape about the centre and sets a rigid motion with the same momentum and
  // angular momentum. The rate grows, because folds of thin sheets can snap back between frames.
  recovery_.degenerate_s += frame_s;
  const double doublings = recovery_.degenerate_s / kLastingTime_s - 1.0;
  const double part = 1.0 - std::exp(-kBlendRate_per_s * std::exp2(doublings) * frame_s);
  const Matrix3d rotation = nearest_rotation(fit);
  const Vector3d velocity = ledger_.motion.velocity_m_s(), l = ledger_.motion.angular_momentum,
                 centre = ledger_.motion.centre_m;
  std::vector<Vector3d> was(masses_kg_.size()), now(was.size());
  const std::vector<Vector3d> still(was.size(), Vector3d::Zero());
  for (size_t i = 0; i < was.size(); ++i) was[i] = nodes_.position_m(i);
  const auto pull = [&](double share) {
    for (size_t i = 0; i < was.size(); ++i) {
      now[i] = was[i] + share * (centre + rotation * (lattice_.node_position_m(i) - rest_centre) - was[i]);
    }
    const Matrix3d map = moment_map_now();
    const Matrix3d second = second_moments_of(body_momentum(now, still, masses_kg_).inertia);
    const Vector3d spin = solve_inertia(inertia_of(map * second * map), l);
    for (size_t i = 0; i < now.size(); ++i)
      nodes_.set_motion(i, now[i], velocity + spin.cross(now[i] - centre));
  };
  const double before_j = elastic_j();
  if (flowed) discard_plastic_flow();
  pull(part);
  // The linear path squashes a sheet, and discarded plastic flow becomes strain. If the energy rises too
  // much, the rest shape is reached at once, because an interruption would leave the squashed state.
  if (elastic_j() > kMaxEnergyGain * before_j) pull(1.0);
  restart_motion();
}

}  // namespace livegs::cells
