// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid_step.h"

#include <algorithm>

#include "core/parallel_for.h"
#include "physics/rigid_contact.h"
#include "physics/rigid_find_contacts.h"

namespace livegs {
namespace {

// Sweeps over all contacts. A body on four points needs a few before its corners share the load evenly; a contact
// costs about 60 ns a sweep.
constexpr int kPushSweeps = 4;
constexpr int kRelaxSweeps = 4;
constexpr int kRestitutionSweeps = 4;

template <class Visit>
void for_each_patch(std::span<RigidBody* const> bodies, const Visit& visit) {
  for (RigidBody* body : bodies) {
    for (ContactPatch& patch : body->patches) {
      if (!body->asleep || (patch.other && !patch.other->asleep)) visit(*body, patch);
    }
  }
}

// Whoever is touched by something faster than rest wakes, before the contact is solved.
void wake_struck(std::span<RigidBody* const> bodies) {
  for (RigidBody* body : bodies) {
    for (const ContactPatch& patch : body->patches) {
      if (!patch.other || body->asleep == patch.other->asleep) continue;
      RigidBody& sleeper = body->asleep ? *body : *patch.other;
      const RigidBody& striker = body->asleep ? *patch.other : *body;
      // Without this substep's gravity, which alone is above the sleep speed of small things.
      const double speed = three_point_speed_m_s(striker, striker.substep_velocity_m_s);
      if (speed < 2.0 * sleep_speed_m_s(striker.shape)) continue;
      sleeper.wake();
    }
  }
}

void accelerate(RigidBody& body, const RigidLoad& load, const Eigen::Vector3d& gravity, double duration_s) {
  body.pushed_by_owner = body.met_body = false;
  if (!body.asleep) body.velocity_m_s += load.implicit_impulse_n_s / body.mass_kg;
  body.substep_velocity_m_s = body.velocity_m_s;
  if (body.asleep) {
    body.substep_acceleration_m_s2.setZero();
    return;
  }
  const Eigen::Vector3d change = duration_s * gravity + load.impulse_n_s / body.mass_kg;
  body.substep_acceleration_m_s2 = change / duration_s;
  body.velocity_m_s += change;
  body.apply_angular_impulse(load.angular_impulse);
}

void tally_blow(RigidBody& body, const ContactPoint& point, const Eigen::Vector3d& normal,
                const Eigen::Vector3d& where) {
  if (point.impulse_n_s <= 0.0) return;
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  body.substep_blow.add(point.impulse_n_s, body_from_world * normal,
                        body_from_world * (where - body.world_from_body.position_m));
  body.carried_speed_m_s =
      std::max(body.carried_speed_m_s, -point.touching_s * normal.dot(body.substep_acceleration_m_s2));
}

// The impulse that carries a body's own weight is no blow: without it a drop gives m v (1 + e), whenever in the tick it
// lands and however long the substep is.
void add_blows(RigidBody& body) {
  ImpulseSum& last = body.substep_blow;
  if (last.impulse_n_s > 0.0) {
    const double share = std::max(0.0, 1.0 - body.mass_kg * body.carried_speed_m_s / last.impulse_n_s);
    body.blow.impulse_n_s += share * last.impulse_n_s;
    body.blow.moment += share * last.moment;
    body.blow.push_n_s += share * last.push_n_s;
  }
  last = {};
  body.carried_speed_m_s = 0.0;
}

void tally(RigidBody& body, ContactPatch& patch) {
  bool struck = false;
  for (int i = 0; i < patch.point_count; ++i) {
    ContactPoint& point = patch.points[i];
    const Eigen::Vector3d where = body.world_from_body.position_m + point.arm_a_m;
    body.contact_impulse_n_s += point.impulse_n_s;
    body.contact_moment += point.impulse_n_s * where;
    tally_blow(body, point, point.normal, where);
    if (patch.other) {
      tally_blow(*patch.other, point, -point.normal, where);
      patch.other->contact_impulse_n_s += point.impulse_n_s;
      patch.other->contact_moment += point.impulse_n_s * where;
    }
    // The impulse of an impact is no forecast of the next substep's.
    if (point.impact_speed_m_s >= patch.restitution_speed_m_s) {
      point.impulse_n_s = 0.0;
      struck = true;
    }
  }
  if (struck) {
    patch.friction_impulse_n_s.setZero();
    patch.twist_impulse = 0.0;
  }
}

}  // namespace

void step_rigid_bodies(std::span<RigidBody* const> bodies, std::span<const RigidLoad> loads,
                       std::span<const Collider> colliders, const Eigen::Vector3d& gravity_m_s2, double duration_s) {
  for (size_t i = 0; i < bodies.size(); ++i) accelerate(*bodies[i], loads[i], gravity_m_s2, duration_s);
  parallel_for(bodies.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      find_contacts(*bodies[i], colliders, bodies, gravity_m_s2.norm(), duration_s);
    }
  });
  wake_struck(bodies);

  for_each_patch(bodies, prepare_patch);
  for_each_patch(bodies, warm_start_patch);
  for (int sweep = 0; sweep < kPushSweeps; ++sweep) {
    for_each_patch(bodies, [&](RigidBody& body, ContactPatch& patch) {
      solve_patch(body, patch, ContactPhase::Push, duration_s);
    });
  }
  for_each_patch(bodies, [&](RigidBody& body, ContactPatch& patch) {
    follow_patch(body, patch, duration_s);
    if (patch.other && total_impulse(patch) > 0.0) {
      body.met_body = patch.other->met_body = patch.other->pushed_by_owner = true;
    }
  });
  for (RigidBody* body : bodies) {
    if (!body->asleep) body->move(duration_s);
  }

  for_each_patch(bodies, prepare_patch);
  for (int sweep = 0; sweep < kRelaxSweeps; ++sweep) {
    for_each_patch(bodies, [&](RigidBody& body, ContactPatch& patch) {
      solve_patch(body, patch, ContactPhase::Relax, duration_s);
    });
  }
  for (int sweep = 0; sweep < kRestitutionSweeps; ++sweep) {
    for_each_patch(bodies, [&](RigidBody& body, ContactPatch& patch) {
      if (restitute_patch(body, patch)) rub_patch(body, patch);
    });
  }
  for_each_patch(bodies, tally);
  for (RigidBody* body : bodies) add_blows(*body);
}

void update_sleep(std::span<RigidBody* const> bodies, double tick_s) {
  for (RigidBody* body : bodies) {
    if (body->asleep) continue;
    bool touching = body->pushed_by_owner;
    for (const ContactPatch& patch : body->patches) touching = touching || total_impulse(patch) > 0.0;
    const bool still = touching && three_point_speed_m_s(*body, body->velocity_m_s) < sleep_speed_m_s(body->shape);
    body->still_s = still ? body->still_s + tick_s : 0.0;
    if (body->still_s < kSleepSeconds) continue;
    body->asleep = true;
    body->velocity_m_s.setZero();
    body->angular_momentum.setZero();
    body->update_turning();
  }
}

}  // namespace livegs
