// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/impact_record.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>

#include "physics/rigid/contact/contact_point.h"

namespace livegs {
namespace {

// Adds an impulse given in world axes. Returns whether it is non-zero.
bool add_load(ImpulseAccumulator& sum, const Eigen::Quaterniond& world_from_body,
              const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& point_m) {
  const double size = impulse_n_s.norm();
  if (!(size > 0.0)) return false;
  const Eigen::Quaterniond body_from_world = world_from_body.conjugate();
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

void ImpactRecord::record_force(const Eigen::Quaterniond& world_from_body, const Eigen::Vector3d& impulse_n_s,
                                const Eigen::Vector3d& point_m) {
  if (add_load(forces_, world_from_body, impulse_n_s, point_m)) forces_.restitution = 1.0;
}

void ImpactRecord::record_joint(const Eigen::Quaterniond& world_from_body, const Eigen::Vector3d& impulse_n_s,
                                const Eigen::Vector3d& point_m, ImpulseKind kind, double remaining_s) {
  const bool impact = kind == ImpulseKind::Impact;
  if (add_load(impact ? impacts_ : contacts_, world_from_body, impulse_n_s, point_m) && impact)
    impact_age_s_ = std::max(impact_age_s_, remaining_s);
}

void ImpactRecord::record_contact(const Eigen::Quaterniond& world_from_body, const ContactManifold& manifold,
                                  const ContactPoint& point, const Eigen::Vector3d& normal,
                                  const Eigen::Vector3d& point_m, ImpulseKind kind, double remaining_s) {
  if (point.impulse_n_s <= 0.0) return;
  const bool impact = kind == ImpulseKind::Impact;
  double at_touch = 1.0;  // an impact is resolved up to a step before it would happen
  if (impact) {
    if (point.leaving_m_s >= 0.0)
      at_touch = (1.0 + manifold.restitution) * point.touch_m_s / (point.closing_m_s + *point.leaving_m_s);
    impact_age_s_ = std::max(impact_age_s_, remaining_s);
  }
  ImpulseAccumulator& sum = impact ? impacts_ : contacts_;
  const Eigen::Quaterniond body_from_world = world_from_body.conjugate();
  sum.add(at_touch * point.impulse_n_s, body_from_world * normal, body_from_world * point_m);
  sum.restitution = std::max(sum.restitution, manifold.restitution);
  if (manifold.other) sum.from_colliders = false;
}

void ImpactRecord::record_friction(const Eigen::Quaterniond& world_from_body,
                                   const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& twist,
                                   const Eigen::Vector3d& point_m, ImpulseKind kind) {
  ImpulseAccumulator& sum = kind == ImpulseKind::Impact ? impacts_ : contacts_;
  const Eigen::Quaterniond body_from_world = world_from_body.conjugate();
  sum.total_n_s += body_from_world * impulse_n_s;
  sum.total_moment += body_from_world * (point_m.cross(impulse_n_s) + twist);
}

void ImpactRecord::end_substep(double duration_s) {
  for (RecentImpact& one : recent_) one.age_s += duration_s;
  std::erase_if(recent_,
                [&](const RecentImpact& one) { return one.age_s - duration_s > kImpactWindow_s - 1e-9; });
  if (impacts_.impulse_n_s > 0.0) {
    recent_.push_back({impact_age_s_, impacts_});
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
  sustained_.add(contacts_, 1.0);
  if (kImpactDuration_s / duration_s * forces_.impulse_n_s > forced_.impulse_n_s) {
    forced_ = {};
    forced_.add(forces_, kImpactDuration_s / duration_s);
  }
  contacts_ = forces_ = impacts_ = {};
  impact_age_s_ = 0.0;
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
