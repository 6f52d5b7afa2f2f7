// SPDX-License-Identifier: GPL-3.0-or-later
// Rolling resistance of a soft body, and of balls on one. Rolling deforms the contact zone continuously, and
// part of the strain energy is lost: a couple against the spin, M = 3/16 alpha P a for a cylinder or ball
// with load P and contact radius a, with alpha the fraction of strain energy lost per cycle (Johnson 1985,
// Contact mechanics, 9.4). The damping of the sweep barely acts on it, because slow rolling deforms slowly.
// Without rolling resistance, a soft ball rocks for minutes, and a rigid ball rolls off a soft block.
#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Minimum decay time of the spin; prevents excitation of jittering bodies.
constexpr double kSpinDecayTime_s = 0.02;

struct Push {
  Vector3d at_m, impulse_n_s;
};

// Resisting couple about a unit axis, N m s; 0 without load. `patch_m2` is the mean square extent of the area
// that each point represents, along a line.
double rolling_resistance(const std::vector<Push>& pushes, const Vector3d& axis, double loss_factor,
                          double patch_m2 = 0.0) {
  double pressed = 0.0;
  Vector3d push = Vector3d::Zero(), centre = Vector3d::Zero();
  for (const auto& [at_m, impulse_n_s] : pushes) {
    const double size = impulse_n_s.norm();
    pressed += size;
    centre += size * at_m;
    push += impulse_n_s;
  }
  const double through = push.norm();
  if (!(through > 0.0)) return 0.0;
  centre /= pressed;
  double variance = patch_m2;
  for (const auto& [at_m, impulse_n_s] : pushes) {
    variance += impulse_n_s.norm() / pressed * axis.cross(at_m - centre).squaredNorm();
  }
  // Hertzian pressure over a circle of radius a: mean square extent a² / 5 along a line.
  const double radius_m = std::sqrt(5.0 * variance), lost = std::min(1.0, 2.0 * M_PI * loss_factor);
  return 3.0 / 16.0 * lost * through * radius_m;
}

}  // namespace

// Rolling on colliders, by the contact impulses from `first_contact` on.
void CellsBody::apply_rolling_resistance(size_t first_contact, double step_s) {
  // No rolling resistance during impacts.
  if (!free() || !is_slow_ || collider_contacts_.size() == first_contact) return;
  const Vector3d spin = motion_.angular_velocity_rad_s();
  const double speed = spin.norm();
  if (!(speed > 0.0)) return;
  std::vector<Push> pushes;
  for (size_t i = first_contact; i < collider_contacts_.size(); ++i) {
    pushes.push_back(
        {nodes_.corrected_m(surface_[collider_contacts_[i].sample]), collider_contacts_[i].impulse_n_s});
  }
  const Vector3d axis = spin / speed;
  const double part = std::min(1.0, step_s / kSpinDecayTime_s), inertia = axis.dot(motion_.inertia * axis);
  contact_moment_ -=
      std::min(rolling_resistance(pushes, axis, material_.loss_factor), part * inertia * speed) * axis;
}

// Resistance of balls that roll on this body, by the rows that it listed. Only balls: faces rest on their
// own, and a box leaning on a block and a floor would jitter between them. A held body takes part. The spin
// ends as soon as the couple suffices; a decay over kSpinDecayTime_s would let balls creep away.
void CellsBody::apply_rolling_resistance(std::span<const ContactConstraint> rows) {
  if (!is_slow_) return;
  std::vector<RigidProxy*> met;
  for (const ContactConstraint& row : rows) {
    const bool rolls = row.rigid && row.rigid->shape->is_ball() && row.normal_impulse_n_s > 0.0;
    if (rolls && std::find(met.begin(), met.end(), row.rigid) == met.end()) met.push_back(row.rigid);
  }
  const double patch_m2 = extent_.box_edge_m * extent_.box_edge_m / 12.0;
  std::vector<Push> pushes;
  for (RigidProxy* rigid : met) {
    const Vector3d spin = rigid->spin_rad_s - (free() ? motion_.angular_velocity_rad_s() : Vector3d::Zero());
    const double speed = spin.norm();
    if (!(speed > 0.0)) continue;
    pushes.clear();
    for (const ContactConstraint& row : rows) {
      if (row.rigid != rigid || !(row.normal_impulse_n_s > 0.0)) continue;
      pushes.push_back({row.point_m - origin_m_, row.normal_impulse_n_s * row.normal});
    }
    const Vector3d axis = spin / speed;
    double mobility = axis.dot(rigid->inverse_inertia * axis);
    if (free()) mobility += axis.dot(solve_inertia(motion_.inertia, axis));
    const double couple_n_m_s =
        std::min(rolling_resistance(pushes, axis, material_.loss_factor, patch_m2), speed / mobility);
    const Vector3d couple = couple_n_m_s * axis;
    rigid->turn(-couple);
    contact_moment_ += couple;
  }
}

}  // namespace livegs
