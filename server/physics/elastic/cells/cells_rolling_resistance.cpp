// SPDX-License-Identifier: GPL-3.0-or-later
// Rolling friction of a soft body, and of what rolls on one. What rolls is pressed flat or presses a pit,
// which springs back all the time, and a part of that energy is lost: a couple against the spin, M = 3/16
// alpha P a for a cylinder or ball that presses with P on a contact of radius a, alpha the part of the strain
// energy that a cycle takes (Johnson 1985, Contact mechanics, 9.4). The damping of the sweep sees next to
// nothing of it, because what rolls slowly deforms slowly; without it a soft ball on a floor rocks for
// minutes, and a rigid one on a soft block, which is no higher in one pit than in another, rolls off.
#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/elastic/cells/cells_body.h"
#include "physics/elastic/rigid_proxy.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kSpinDecayTime_s = 0.02;  // no spin is ended sooner: what is_jittering is not stirred

struct Push {
  Vector3d at_m, impulse_n_s;
};

// The couple about a unit axis, N m s; 0 where nothing presses.
// Each point speaks for `patch_m2` more, the mean square of what it stands for along a line.
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
  // Hertz's pressure over a circle of radius a: a mean square of a² / 5 along a line.
  const double radius_m = std::sqrt(5.0 * variance), lost = std::min(1.0, 2.0 * M_PI * loss_factor);
  return 3.0 / 16.0 * lost * through * radius_m;
}

}  // namespace

// On colliders; the impulses of the touches from `first_contact` on.
void CellsBody::apply_rolling_resistance(size_t first_contact, double step_s) {
  if (!free() || !is_slow_ || collider_contacts_.size() == first_contact)
    return;  // an impact is not rolled through
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

// Of balls against this one, by the rows that it listed: what has faces rests on them, and a box that leans
// on a block and a floor would tremble between them. A body that is held takes its part. The spin ends as
// soon as the couple can end it: what was let to go on for kSpinDecayTime_s crept off in seconds.
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
