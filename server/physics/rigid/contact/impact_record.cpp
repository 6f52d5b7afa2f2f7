// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/impact_record.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

// Time constant of transmitted loads, s; a load that lasts longer counts as sustained.
constexpr double kLoadFilterTime_s = 0.004;

// Adds an impulse given in world axes. Returns whether it is non-zero.
bool add_load(ImpulseAccumulator& sum, const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
              const Eigen::Vector3d& point_m) {
  const double size = impulse_n_s.norm();
  if (!(size > 0.0)) return false;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  sum.add(size, body_from_world * (impulse_n_s / size), body_from_world * point_m);
  sum.from_colliders = false;
  return true;
}

}  // namespace

void ImpulseAccumulator::add(double size_n_s, const Eigen::Vector3d& direction,
                             const Eigen::Vector3d& point_m) {
  impulse_n_s += size_n_s;
  moment += size_n_s * point_m;
  push_n_s += size_n_s * direction;
  total_n_s += size_n_s * direction;
  total_moment += size_n_s * point_m.cross(direction);
  spread += size_n_s * direction * direction.transpose();
}

void ImpulseAccumulator::add(const ImpulseAccumulator& other, double share) {
  if (!(share * other.impulse_n_s > 0.0)) return;
  impulse_n_s += share * other.impulse_n_s;
  moment += share * other.moment;
  push_n_s += share * other.push_n_s;
  total_n_s += share * other.total_n_s;
  total_moment += share * other.total_moment;
  spread += share * other.spread;
  from_colliders = from_colliders && other.from_colliders;
  restitution = std::max(restitution, other.restitution);
}

void ImpactRecord::record_force(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                                const Eigen::Vector3d& point_m) {
  if (add_load(forces_, body, impulse_n_s, point_m)) forces_.restitution = 1.0;
}

void ImpactRecord::record_joint(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                                const Eigen::Vector3d& point_m) {
  add_load(contacts_, body, impulse_n_s, point_m);
}

void ImpactRecord::record_contact(const RigidBody& body, const ContactManifold& manifold,
                                  const ContactPoint& point, const Eigen::Vector3d& normal,
                                  const Eigen::Vector3d& point_m) {
  if (point.impulse_n_s <= 0.0) return;
  const bool hard = point.impact_speed_m_s >= manifold.restitution_speed_m_s;
  const double ended =
      (hard ? point.impact_speed_m_s : point.approach_speed_m_s) * (1.0 + manifold.restitution);
  double share = ended > 0.0 ? ended / (ended + point.carried_speed_m_s) : 0.0;
  if (hard)
    bounce_fraction_ = std::max(bounce_fraction_, share);
  else
    share *= previous_bounce_fraction_;
  if (share > 0.0) {
    impact_fraction_ = std::max(impact_fraction_, share);
    if (ended > fastest_approach_m_s_) {
      fastest_approach_m_s_ = ended;
      impact_time_s_ = point.time_of_impact_s;
    }
  }
  if (!body.can_break) return;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  contacts_.add(point.impulse_n_s, body_from_world * normal, body_from_world * point_m);
  contacts_.restitution = std::max(contacts_.restitution, manifold.restitution);
  if (manifold.other) contacts_.from_colliders = false;
}

void ImpactRecord::record_friction(const RigidBody& body, const Eigen::Vector3d& impulse_n_s,
                                   const Eigen::Vector3d& twist, const Eigen::Vector3d& point_m) {
  if (!body.can_break) return;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  contacts_.total_n_s += body_from_world * impulse_n_s;
  contacts_.total_moment += body_from_world * (point_m.cross(impulse_n_s) + twist);
}

void ImpactRecord::end_substep(const RigidBody& body, double island_fraction, double duration_s) {
  previous_bounce_fraction_ = std::exchange(bounce_fraction_, 0.0);
  if (!body.can_break) {
    impact_fraction_ = fastest_approach_m_s_ = 0.0;
    return;
  }
  const double size = contacts_.impulse_n_s, now_n = size / duration_s;
  double struck = 0.0;
  if (island_fraction > 0.0) {
    // The previous sustained force continues. A transmitted impulse originates from elsewhere in the island.
    const bool passed_on = impact_fraction_ == 0.0;
    if (passed_on && !sustained_force_known_) sustained_force_n_ = now_n;
    struck = (passed_on ? island_fraction : impact_fraction_) *
             std::max(0.0, size - duration_s * sustained_force_n_);
    if (passed_on)
      sustained_force_n_ += std::min(1.0, duration_s / kLoadFilterTime_s) * (now_n - sustained_force_n_);
  } else {
    sustained_force_n_ = now_n;
  }
  sustained_force_known_ = sustained_force_known_ || size > 0.0;

  for (RecentImpact& one : recent_) one.age_s += duration_s;
  std::erase_if(recent_,
                [&](const RecentImpact& one) { return one.age_s - duration_s > kImpactWindow_s - 1e-9; });
  if (struck > 0.0) {
    recent_.push_back({fastest_approach_m_s_ > 0.0 ? duration_s - impact_time_s_ : 0.0, {}});
    recent_.back().sum.add(contacts_, struck / size);
    ImpulseAccumulator together;
    for (const RecentImpact& one : recent_) {
      if (one.age_s - recent_.back().age_s <= kImpactWindow_s - 1e-9) together.add(one.sum, 1.0);
    }
    if (together.impulse_n_s > strongest_.impulse_n_s) strongest_ = together;
    if (together.impulse_n_s > episode_.impulse_n_s) episode_ = together;
  }
  if (recent_.empty()) {
    if (episode_.impulse_n_s > ended_episode_.impulse_n_s) ended_episode_ = episode_;
    episode_ = {};
  }
  sustained_.add(contacts_, 1.0 - struck / std::max(size, 1e-300));
  if (kImpactDuration_s / duration_s * forces_.impulse_n_s > forced_.impulse_n_s) {
    forced_ = {};
    forced_.add(forces_, kImpactDuration_s / duration_s);
  }
  contacts_ = forces_ = {};
  impact_fraction_ = fastest_approach_m_s_ = 0.0;
}

ImpulseAccumulator ImpactRecord::take(double tick_s) {
  ImpulseAccumulator sum = std::exchange(strongest_, {});
  const double struck_n_s = sum.impulse_n_s, restitution = sum.restitution;
  sum.add(std::exchange(sustained_, {}), kImpactDuration_s / tick_s);
  sum.add(std::exchange(forced_, {}), 1.0);
  sum.restitution = 2.0 * struck_n_s > sum.impulse_n_s ? restitution : 1.0;
  return sum;
}

ImpulseAccumulator ImpactRecord::take_ended_episode() { return std::exchange(ended_episode_, {}); }

Eigen::Vector3d direction_of(const ImpulseAccumulator& sum) {
  // Below this ratio of |sum| to sum of magnitudes the impulses count as a squeeze.
  constexpr double kMinNetShare = 0.5;
  const double push = sum.push_n_s.norm();
  if (push > kMinNetShare * sum.impulse_n_s) return sum.push_n_s / push;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(sum.spread);
  const Eigen::Vector3d axis = axes.eigenvectors().col(2);
  return axis.dot(sum.moment) > 0.0 ? Eigen::Vector3d(-axis) : axis;  // inwards
}

}  // namespace livegs
