// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/impact_phase.h"

#include <algorithm>
#include <deque>
#include <vector>

#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/joint/joint_group.h"

namespace livegs {
namespace {

// Maximum number of rounds, and of sweeps in each; an impulse passes one more body of a row in each round.
// Closing contacts that are left then do not bounce. Larger: impulses pass along longer rows, more time.
constexpr int kMaxImpactRounds = 64;
// Closing speed, relative to the fastest of the impact, down to which it is passed on. Smaller: more rounds.
constexpr double kPassedOn = 0.01;

// Fraction of the impulses since `before` with which kinetic energy does not grow: E(s) = before + s linear +
// s² square.
double fraction_within_energy(std::span<RigidBody* const> bodies, std::span<const RigidMotion> before) {
  double linear = 0.0, square = 0.0;
  for (size_t i = 0; i < bodies.size(); ++i) {
    const RigidBody& body = *bodies[i];
    if (body.asleep) continue;
    const Eigen::Vector3d change = body.velocity_m_s - before[i].velocity_m_s,
                          turn = body.angular_momentum - before[i].angular_momentum;
    linear += body.mass_kg * before[i].velocity_m_s.dot(change) + before[i].angular_velocity_rad_s.dot(turn);
    square += 0.5 * (body.mass_kg * change.squaredNorm() +
                     turn.dot(body.angular_velocity_rad_s - before[i].angular_velocity_rad_s));
  }
  return square > 0.0 && linear + square > 0.0 ? std::clamp(-linear / square, 0.0, 1.0) : 1.0;
}

void scale_motion(std::span<RigidBody* const> bodies, std::span<const RigidMotion> before, double part) {
  for (size_t i = 0; i < bodies.size(); ++i) {
    RigidBody& body = *bodies[i];
    if (body.asleep) continue;
    const auto cut = [part](Eigen::Vector3d& now, const Eigen::Vector3d& was) {
      now = was + part * (now - was);
    };
    cut(body.velocity_m_s, before[i].velocity_m_s);
    cut(body.angular_momentum, before[i].angular_momentum);
    cut(body.angular_velocity_rad_s, before[i].angular_velocity_rad_s);
  }
}

void record_point(RigidBody& body, const ContactManifold& manifold, const RigidBody* from,
                  const ContactPoint& point, const Eigen::Vector3d& normal, const Eigen::Vector3d& where,
                  ImpulseKind kind, double remaining_s) {
  body.contact_impulse_n_s += point.impulse_n_s;
  if (!from || from->object_id != body.object_id) {
    body.external_contact_impulse_n_s += point.impulse_n_s;
    body.external_contact_moment += point.impulse_n_s * where;
  }
  if (!body.can_break) return;
  body.impacts.record_contact(body.world_from_body.orientation, manifold, point, normal,
                              where - body.world_from_body.position_m, kind, remaining_s);
}

}  // namespace

void record_impulses(RigidBody& body, const ContactManifold& manifold, ImpulseKind kind, double remaining_s) {
  RigidBody* const other = manifold.other;
  for (const ContactPoint& point : manifold.used()) {
    const Eigen::Vector3d where = body.world_from_body.position_m + point.arm_a_m;
    if (!body.asleep) record_point(body, manifold, other, point, point.normal, where, kind, remaining_s);
    if (other && !other->asleep)
      record_point(*other, manifold, &body, point, -point.normal, where, kind, remaining_s);
  }
  const Eigen::Vector3d &rubbed = manifold.friction_impulse_n_s,
                        twist = manifold.twist_impulse * manifold.normal;
  if (body.can_break)
    body.impacts.record_friction(body.world_from_body.orientation, rubbed, twist, manifold.arm_a_m, kind);
  if (other && other->can_break)
    other->impacts.record_friction(other->world_from_body.orientation, -rubbed, -twist, manifold.arm_b_m,
                                   kind);
}

void resolve_impacts(const RigidIsland& island, std::span<JointGroup* const> joints, double step_s,
                     double remaining_s) {
  std::deque<ManifoldRows> rows;  // of the contacts that closed in a round
  std::vector<ManifoldRows*> rows_of_contact(island.contacts.size(), nullptr);
  std::vector<const RigidIsland::Contact*> closing;
  const auto rows_of = [&](const RigidIsland::Contact* contact) -> ManifoldRows& {
    return *rows_of_contact[static_cast<size_t>(contact - island.contacts.data())];
  };
  const auto find_closing = [&](double passed_on_m_s) {
    closing.clear();
    double fastest_m_s = 0.0;
    for (const RigidIsland::Contact& contact : island.contacts) {
      const double speed_m_s = begin_impact(*contact.owner, *contact.manifold, step_s, passed_on_m_s);
      if (speed_m_s <= 0.0) continue;
      ManifoldRows*& of_contact = rows_of_contact[static_cast<size_t>(&contact - island.contacts.data())];
      if (!of_contact) of_contact = &rows.emplace_back(prepare_rows(*contact.owner, *contact.manifold));
      closing.push_back(&contact);
      fastest_m_s = std::max(fastest_m_s, speed_m_s);
    }
    return fastest_m_s;
  };
  const double fastest_m_s = find_closing(0.0);
  if (closing.empty()) return;

  std::vector<RigidMotion> before(island.bodies.size());
  for (int round = 0; round < kMaxImpactRounds && !closing.empty(); ++round) {
    std::vector<ContactManifold> resting;  // impulses for the warm start of the step
    for (const RigidIsland::Contact* contact : closing) {
      resting.push_back(*contact->manifold);
      for (ContactPoint& point : contact->manifold->points) {
        point.impulse_n_s = 0.0;
        point.friction_impulse_n_s.setZero();
      }
      contact->manifold->friction_impulse_n_s.setZero();
      contact->manifold->twist_impulse = 0.0;
      rows_of(contact).friction.clear();
    }
    for (size_t i = 0; i < before.size(); ++i) before[i] = island.bodies[i]->motion();
    for (JointGroup* group : joints) group->begin_impact();
    for (int sweep = 0; sweep < kMaxImpactRounds; ++sweep) {
      double change_m_s = 0.0;
      for (const RigidIsland::Contact* contact : closing) {
        change_m_s =
            std::max(change_m_s, solve_impact(*contact->owner, *contact->manifold, rows_of(contact)));
        solve_friction(*contact->owner, *contact->manifold, rows_of(contact));
      }
      for (JointGroup* group : joints) group->solve_impact();
      if (change_m_s <= 1e-7 * fastest_m_s) break;
    }
    const double part = fraction_within_energy(island.bodies, before);
    if (part < 1.0) scale_motion(island.bodies, before, part);
    for (JointGroup* group : joints) group->end_impact(part, remaining_s);
    for (size_t i = 0; i < closing.size(); ++i) {
      ContactManifold& manifold = *closing[i]->manifold;
      store_friction(manifold, rows_of(closing[i]));
      if (part < 1.0) scale_impulses(manifold, part);
      record_impulses(*closing[i]->owner, manifold, ImpulseKind::Impact, remaining_s);
      manifold = resting[i];
    }
    find_closing(kPassedOn * fastest_m_s);
  }
}

}  // namespace livegs
