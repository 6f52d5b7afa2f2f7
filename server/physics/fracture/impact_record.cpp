// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/fracture/impact_record.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

constexpr double kLoadTime_s = 0.004;  // what is passed on through a body for longer than this is a load

// In world axes. Whether there is anything.
bool add_held(ImpulseSum& sum, const RigidBody& body, const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& point_m) {
  const double size = impulse_n_s.norm();
  if (!(size > 0.0)) return false;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  sum.add(size, body_from_world * (impulse_n_s / size), body_from_world * point_m);
  sum.from_colliders = false;
  return true;
}

}  // namespace

void ImpulseSum::add(double size_n_s, const Eigen::Vector3d& direction, const Eigen::Vector3d& point_m) {
  impulse_n_s += size_n_s;
  moment += size_n_s * point_m;
  push_n_s += size_n_s * direction;
  given_n_s += size_n_s * direction;
  given_moment += size_n_s * point_m.cross(direction);
  spread += size_n_s * direction * direction.transpose();
}

void ImpulseSum::add(const ImpulseSum& other, double share) {
  if (!(share * other.impulse_n_s > 0.0)) return;
  impulse_n_s += share * other.impulse_n_s;
  moment += share * other.moment;
  push_n_s += share * other.push_n_s;
  given_n_s += share * other.given_n_s;
  given_moment += share * other.given_moment;
  spread += share * other.spread;
  from_colliders = from_colliders && other.from_colliders;
  restitution = std::max(restitution, other.restitution);
}

void RigidBlows::note_force(const RigidBody& body, const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& point_m) {
  if (add_held(forces_, body, impulse_n_s, point_m)) forces_.restitution = 1.0;
}

void RigidBlows::note_joint(const RigidBody& body, const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& point_m) {
  add_held(contacts_, body, impulse_n_s, point_m);
}

void RigidBlows::note_contact(const RigidBody& body, const ContactPatch& patch, const ContactPoint& point,
                              const Eigen::Vector3d& normal, const Eigen::Vector3d& point_m) {
  if (point.impulse_n_s <= 0.0) return;
  const bool hard = point.impact_speed_m_s >= patch.restitution_speed_m_s;
  const double ended = (hard ? point.impact_speed_m_s : point.approach_speed_m_s) * (1.0 + patch.restitution);
  double share = ended > 0.0 ? ended / (ended + point.carried_speed_m_s) : 0.0;
  if (hard)
    hard_share_ = std::max(hard_share_, share);
  else
    share *= earlier_share_;
  if (share > 0.0) {
    struck_share_ = std::max(struck_share_, share);
    if (ended > fastest_ended_m_s_) {
      fastest_ended_m_s_ = ended;
      struck_after_s_ = point.until_touch_s;
    }
  }
  if (!body.can_break) return;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  contacts_.add(point.impulse_n_s, body_from_world * normal, body_from_world * point_m);
  contacts_.restitution = std::max(contacts_.restitution, patch.restitution);
  if (patch.other) contacts_.from_colliders = false;
}

void RigidBlows::note_friction(const RigidBody& body, const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& twist,
                               const Eigen::Vector3d& point_m) {
  if (!body.can_break) return;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  contacts_.given_n_s += body_from_world * impulse_n_s;
  contacts_.given_moment += body_from_world * (point_m.cross(impulse_n_s) + twist);
}

void RigidBlows::end_substep(const RigidBody& body, double island_share, double duration_s) {
  earlier_share_ = std::exchange(hard_share_, 0.0);
  if (!body.can_break) {
    struck_share_ = fastest_ended_m_s_ = 0.0;
    return;
  }
  const double size = contacts_.impulse_n_s, now_n = size / duration_s;
  double struck = 0.0;
  if (island_share > 0.0) {
    // What it bore before, it bears on. What is passed on to it came from elsewhere in the island.
    const bool passed_on = struck_share_ == 0.0;
    if (passed_on && !borne_known_) borne_n_ = now_n;
    struck = (passed_on ? island_share : struck_share_) * std::max(0.0, size - duration_s * borne_n_);
    if (passed_on) borne_n_ += std::min(1.0, duration_s / kLoadTime_s) * (now_n - borne_n_);
  } else {
    borne_n_ = now_n;
  }
  borne_known_ = borne_known_ || size > 0.0;

  for (Struck& one : recent_) one.age_s += duration_s;
  std::erase_if(recent_, [&](const Struck& one) { return one.age_s - duration_s > kFrame_s - 1e-9; });
  if (struck > 0.0) {
    recent_.push_back({fastest_ended_m_s_ > 0.0 ? duration_s - struck_after_s_ : 0.0, {}});
    recent_.back().sum.add(contacts_, struck / size);
    ImpulseSum together;
    for (const Struck& one : recent_) {
      if (one.age_s - recent_.back().age_s <= kFrame_s - 1e-9) together.add(one.sum, 1.0);
    }
    if (together.impulse_n_s > blow_.impulse_n_s) blow_ = together;
    if (together.impulse_n_s > spell_.impulse_n_s) spell_ = together;
  }
  if (recent_.empty()) {
    if (spell_.impulse_n_s > over_.impulse_n_s) over_ = spell_;
    spell_ = {};
  }
  pressed_.add(contacts_, 1.0 - struck / std::max(size, 1e-300));
  if (kBlowTime_s / duration_s * forces_.impulse_n_s > pushed_.impulse_n_s) {
    pushed_ = {};
    pushed_.add(forces_, kBlowTime_s / duration_s);
  }
  contacts_ = forces_ = {};
  struck_share_ = fastest_ended_m_s_ = 0.0;
}

ImpulseSum RigidBlows::take(double tick_s) {
  ImpulseSum sum = std::exchange(blow_, {});
  const double struck_n_s = sum.impulse_n_s, restitution = sum.restitution;
  sum.add(std::exchange(pressed_, {}), kBlowTime_s / tick_s);
  sum.add(std::exchange(pushed_, {}), 1.0);
  sum.restitution = 2.0 * struck_n_s > sum.impulse_n_s ? restitution : 1.0;
  return sum;
}

ImpulseSum RigidBlows::take_spell() { return std::exchange(over_, {}); }

Eigen::Vector3d direction_of(const ImpulseSum& sum) {
  constexpr double kOneSided = 0.5;
  const double push = sum.push_n_s.norm();
  if (push > kOneSided * sum.impulse_n_s) return sum.push_n_s / push;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(sum.spread);
  const Eigen::Vector3d axis = axes.eigenvectors().col(2);
  return axis.dot(sum.moment) > 0.0 ? Eigen::Vector3d(-axis) : axis;  // inwards
}

}  // namespace livegs
