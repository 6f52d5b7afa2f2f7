// SPDX-License-Identifier: GPL-3.0-or-later
// Energy limit of joint groups: a group may only gain the work of external impulses.
#include <algorithm>
#include <cmath>

#include "physics/ablation/ablation.h"
#include "physics/motion/free_rotation.h"
#include "physics/rigid/joint/joint_group.h"

namespace livegs {
namespace {

// Tolerated apparent work of joints, relative to the recent peak of kinetic energy, because steps are of
// second order.
constexpr double kWorkTolerance = 1e-3;
// Decay time of the peak of kinetic energy, s.
constexpr double kEnergyMemory_s = 2.0;

}  // namespace

void JointGroup::begin() {
  for (size_t i = 0; i < bodies_.size(); ++i) {
    starts_[i] = bodies_[i]->motion();
    starts_[i].velocity_m_s = bodies_[i]->substep_velocity_m_s;
    before_[i] = starts_[i];
    given_[i] = others_[i] = {};
  }
}

// Adds the velocity changes since `before_` that are not from joints, and resets `before_`.
void JointGroup::note_others() {
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const RigidBody& body = *bodies_[i];
    others_[i].push_n_s += body.mass_kg * (body.velocity_m_s - before_[i].velocity_m_s) - given_[i].push_n_s;
    others_[i].turn += body.angular_momentum - before_[i].angular_momentum - given_[i].turn;
    before_[i] = body.motion();
    given_[i] = {};
  }
}

// Limits the kinetic energy to the work of `others`, with the mean of the motion before and after, plus
// `allowance_j`. Scales the group's motion, for a free group the motion about its centre, and returns the
// factor. Linear momentum is conserved; a free group's angular momentum about its centre is scaled too.
double JointGroup::limit_kinetic_energy(const std::vector<RigidMotion>& starts,
                                        const std::vector<Impulses>& others, double allowance_j) {
  Eigen::Vector3d common = Eigen::Vector3d::Zero();
  double common_j = 0.0;
  if (std::ranges::all_of(joints_, &RigidJoint::b)) {  // none to the world
    double mass_kg = 0.0;
    for (const RigidBody* body : bodies_) {
      mass_kg += body->mass_kg;
      common += body->mass_kg * body->velocity_m_s;
    }
    common /= mass_kg;
    common_j = 0.5 * mass_kg * common.squaredNorm();
  }
  // With internal motion scaled by f: own_j f² = gained_j f + start_j.
  double own_j = -common_j, gained_j = 0.0, start_j = allowance_j - common_j, rounding_j = 0.0;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const RigidBody& body = *bodies_[i];
    own_j += body.kinetic_j();
    start_j += starts[i].kinetic_j(body.mass_kg);
    start_j += 0.5 * (others[i].push_n_s.dot(starts[i].velocity_m_s + common) +
                      others[i].turn.dot(starts[i].angular_velocity_rad_s));
    gained_j += 0.5 * (others[i].push_n_s.dot(body.velocity_m_s - common) +
                       others[i].turn.dot(body.angular_velocity_rad_s));
    // Relative to the energy that the held bodies would have gained in free motion.
    rounding_j += 1e-18 * others[i].push_n_s.squaredNorm() / body.mass_kg;
  }
  if (!(own_j > gained_j + start_j + rounding_j) || without(Mechanism::JointEnergyLimit))
    return 1.0;  // suspended bodies at rest keep their load
  const double root = std::sqrt(std::max(0.0, gained_j * gained_j + 4.0 * own_j * start_j));
  const double factor = own_j > 0.0 ? std::clamp(0.5 * (gained_j + root) / own_j, 0.0, 1.0) : 1.0;
  for (RigidBody* body : bodies_) {
    body->velocity_m_s = common + factor * (body->velocity_m_s - common);
    body->angular_momentum *= factor;
    body->angular_velocity_rad_s *= factor;
  }
  return factor;
}

// Near a straight line, closing a joint requires fast transverse motion: limits it to twice the available
// energy.
void JointGroup::limit_push() {
  note_others();
  double fastest_m_s = 0.0, mass_kg = 0.0, start_j = 0.0;
  for (const Rows& rows : rows_) fastest_m_s = std::max(fastest_m_s, rows.correction_m_s);
  for (size_t i = 0; i < bodies_.size(); ++i) {
    mass_kg += bodies_[i]->mass_kg;
    start_j += starts_[i].kinetic_j(bodies_[i]->mass_kg);
  }
  const double factor =
      limit_kinetic_energy(starts_, others_, start_j + 0.5 * mass_kg * fastest_m_s * fastest_m_s);
  if (factor == 1.0) return;
  for (RigidJoint& joint : joints_) joint.push = joint.push * factor;
  for (size_t i = 0; i < bodies_.size(); ++i) before_[i] = bodies_[i]->motion();
}

void JointGroup::end(double substep_s) {
  note_others();
  double work_j = 0.0, lifted_j = 0.0, kinetic = 0.0;
  for (size_t i = 0; i < bodies_.size(); ++i) {
    const RigidBody& body = *bodies_[i];
    const Eigen::Vector3d mean = 0.5 * (starts_[i].velocity_m_s + body.velocity_m_s);
    kinetic += body.kinetic_j();
    work_j += body.kinetic_j() - starts_[i].kinetic_j(body.mass_kg) - others_[i].push_n_s.dot(mean);
    work_j -= 0.5 * others_[i].turn.dot(starts_[i].angular_velocity_rad_s + body.angular_velocity_rad_s);
    const Eigen::Vector3d moved_m = body.world_from_body.position_m - starts_[i].position_m;
    lifted_j -= body.mass_kg * body.substep_acceleration_m_s2.dot(moved_m - substep_s * mean);
  }
  peak_kinetic_j_ = std::max(kinetic, (1.0 - substep_s / kEnergyMemory_s) * peak_kinetic_j_);
  const double tolerance_j = kWorkTolerance * peak_kinetic_j_;
  work_j_ = std::max(work_j_ + work_j + lifted_j, -tolerance_j);
  if (!(work_j_ > tolerance_j)) return;
  limit_kinetic_energy(starts_, others_, work_j - (work_j_ - tolerance_j));
  work_j_ = tolerance_j;
}

}  // namespace livegs
