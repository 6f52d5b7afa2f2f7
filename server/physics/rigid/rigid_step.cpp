// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/rigid_step.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "core/log.h"
#include "core/parallel_for.h"
#include "physics/motion/motion_validity.h"
#include "physics/rigid/contact/contact_lanes.h"
#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/contact/find_contacts.h"
#include "physics/rigid/contact/impact_phase.h"
#include "physics/rigid/joint/joint_group.h"
#include "physics/rigid/rigid_islands.h"
#include "physics/rigid/rigid_sleep.h"
#include "physics/rigid/rigid_spring.h"

namespace livegs {
namespace {

// Solver steps per substep, with one sweep each; contacts are found once per substep. Small steps converge
// better than iterations for high mass ratios and tall stacks (Macklin et al. 2019, Small steps in physics
// simulation), because contacts may be stiffer.
constexpr int kSolverSteps = 4;
constexpr int kRelaxIterations = 2;  // with one, large piles do not come to rest

// Whether the manifold will push within the substep. The last relax sweep looks ahead one more step.
bool will_touch(const RigidBody& owner, const ContactManifold& manifold, double duration_s) {
  for (const ContactPoint& point : manifold.used()) {
    Eigen::Vector3d velocity = owner.point_velocity(point.arm_a_m);
    if (manifold.other) {
      const Eigen::Vector3d between =
          owner.world_from_body.position_m - manifold.other->world_from_body.position_m;
      velocity -= manifold.other->point_velocity(point.arm_a_m + between);
    }
    const double ahead_s = duration_s + duration_s / kSolverSteps;
    if (point.separation_m + ahead_s * point.normal.dot(velocity) < 0.0) return true;
  }
  return false;
}

// Wakes sleeping bodies that will be touched, before contacts are solved.
bool wake_on_contact(std::span<RigidBody* const> bodies, double duration_s) {
  bool any = false;
  for (RigidBody* body : bodies) {
    for (const ContactManifold& manifold : body->manifolds) {
      if (!manifold.other || body->asleep == manifold.other->asleep ||
          !will_touch(*body, manifold, duration_s))
        continue;
      (body->asleep ? *body : *manifold.other).wake();
      any = true;
    }
  }
  return any;
}

// Integrates velocities without contacts; contact search uses the result.
void accelerate(RigidBody& body, const RigidLoad& load, const Eigen::Vector3d& gravity, double duration_s) {
  body.velocity_m_s += load.implicit_impulse_n_s / body.mass_kg;
  body.apply_angular_impulse(load.angular_impulse);
  body.substep_velocity_m_s = body.velocity_m_s;
  body.substep_acceleration_m_s2 = gravity + load.impulse_n_s / (body.mass_kg * duration_s);
  body.velocity_m_s += duration_s * body.substep_acceleration_m_s2;
}

// Records loads of springs and joints, which strain a body like contacts.
void record_held_loads(const RigidIsland& island, std::span<JointGroup* const> joints, double step_s) {
  for (RigidBody* body : island.bodies) {
    for (const RigidSpring* spring : body->springs)
      body->record_force(step_s * spring->force_n, spring->arm_m);
  }
  for (const JointGroup* group : joints) {
    for (const RigidJoint& joint : group->joints())
      joint.record(step_s * joint.force_n, ImpulseKind::Support, 0.0);
  }
}

// Selects the integration of the bodies (see RigidBody::move), which joints take into account.
void mark_contacts(RigidBody& body, ContactManifold& manifold) {
  if (!manifold.other || total_impulse(manifold) <= 0.0) return;
  if (!body.asleep) body.has_body_contact = true;
  if (!manifold.other->asleep) manifold.other->has_body_contact = manifold.other->pushed_by_owner = true;
}

bool has_finite_motion(const RigidBody* body) {
  const Pose& pose = body->world_from_body;
  return body->velocity_m_s.squaredNorm() < kMaxValidSpeed_m_s * kMaxValidSpeed_m_s &&
         is_valid_position(pose.position_m) && pose.orientation.coeffs().allFinite() &&
         body->angular_momentum.allFinite() && body->angular_velocity_rad_s.allFinite();
}

// Restores the start of the substep, at rest, for a diverged island. Otherwise non-finite values would spread
// through contacts.
void restore_last_valid_state(RigidIsland& island, std::span<const Pose> poses,
                              std::span<JointGroup* const> joints) {
  static std::atomic<int> warnings{0};
  const auto lost = std::ranges::find_if_not(island.bodies, has_finite_motion);
  if (warnings.fetch_add(1) < 10) {
    log_warn(
        "object %u: motion diverged, so its island is stopped at the last valid poses; check for overlapping "
        "parts and large mass ratios, or increase substeps",
        (*lost)->object_id);
  }
  for (size_t i = 0; i < island.bodies.size(); ++i) {
    RigidBody& body = *island.bodies[i];
    body.world_from_body = poses[i];
    body.stop();
    body.manifolds.clear();
    body.previous_manifolds.clear();
    body.impacts = ImpactRecord();
    body.contact_impulse_n_s = body.external_contact_impulse_n_s = 0.0;
    body.external_contact_moment.setZero();
  }
  for (JointGroup* group : joints) group->reset_impulses();
}

// Solves an island in `steps` solver steps. Contacts keep the impulses of kSolverSteps steps.
void solve_island(RigidIsland& island, double duration_s, int steps) {
  const auto each = [&](const auto& visit) {
    for (const RigidIsland::Contact& contact : island.contacts) visit(*contact.owner, *contact.manifold);
  };
  const double times = static_cast<double>(steps) / kSolverSteps;
  const double step_s = duration_s / steps;
  if (steps != kSolverSteps) {
    each([&](RigidBody&, ContactManifold& manifold) { scale_impulses(manifold, 1.0 / times); });
  }
  std::vector<Pose> poses;
  for (const RigidBody* body : island.bodies) poses.push_back(body->world_from_body);
  const std::vector<JointGroup*> joints = joint_groups(island.bodies);
  const bool has_springs =
      std::ranges::any_of(island.bodies, [](const RigidBody* body) { return !body->springs.empty(); });
  for (RigidBody* body : island.bodies) body->velocity_m_s = body->substep_velocity_m_s;
  ContactLanes contacts(island, step_s);
  // Joints and springs push the bodies themselves.
  const auto with_bodies = [&](bool needed, const auto& act) {
    if (!needed) return;
    contacts.store_motion();
    act();
    contacts.load_motion();
  };
  for (int step = 0; step < steps; ++step) {
    contacts.load_poses();
    contacts.load_motion();
    contacts.prepare();
    if (contacts.any_impact()) {
      contacts.store_points();
      contacts.store_friction();
      resolve_impacts(island, joints, step_s, (steps - step) * step_s);
    }
    for (RigidBody* body : island.bodies) {
      body->pushed_by_owner = body->has_body_contact = false;
      body->substep_velocity_m_s = body->velocity_m_s;
      body->velocity_m_s += step_s * body->substep_acceleration_m_s2;
    }
    for (JointGroup* group : joints) group->begin();
    contacts.load_motion();
    contacts.warm_start();
    with_bodies(has_springs || !joints.empty(), [&] {
      for (RigidBody* body : island.bodies) {
        for (RigidSpring* spring : body->springs) prepare_spring(*body, *spring, step_s);
      }
      for (JointGroup* group : joints) group->prepare(ContactPhase::Push);
    });
    contacts.sweep(ContactPhase::Push);
    with_bodies(has_springs || !joints.empty(), [&] {
      for (RigidBody* body : island.bodies) {
        for (RigidSpring* spring : body->springs) solve_spring(*body, *spring, step_s);
      }
      if (joints.empty()) return;
      contacts.store_points();
      each(mark_contacts);
      for (JointGroup* group : joints) group->solve(ContactPhase::Push, step_s);
    });
    contacts.update_separations();
    contacts.store_motion();
    contacts.store_points();
    each(mark_contacts);
    for (RigidBody* body : island.bodies) {
      if (!body->joints) body->move(step_s);
    }
    for (JointGroup* group : joints) group->move(step_s);

    for (JointGroup* group : joints) group->prepare(ContactPhase::Relax);
    contacts.load_poses();
    contacts.load_motion();
    contacts.prepare();
    for (int sweep = 0; sweep < kRelaxIterations; ++sweep) {
      contacts.sweep(ContactPhase::Relax);
      with_bodies(!joints.empty(), [&] {
        for (JointGroup* group : joints) group->solve(ContactPhase::Relax, step_s);
      });
    }
    contacts.store_motion();
    contacts.store_points();
    contacts.store_friction();
    for (JointGroup* group : joints) group->end(step_s);
    each([](RigidBody& body, ContactManifold& manifold) {
      record_impulses(body, manifold, ImpulseKind::Support, 0.0);
    });
    record_held_loads(island, joints, step_s);
  }
  if (steps != kSolverSteps) {
    each([&](RigidBody&, ContactManifold& manifold) { scale_impulses(manifold, times); });
  }
  if (!std::ranges::all_of(island.bodies, has_finite_motion)) restore_last_valid_state(island, poses, joints);
  for (RigidBody* body : island.bodies) body->impacts.end_substep(duration_s);
}

// Solves an island's substep in `parts` sub-intervals, each with its own contacts. Its bodies only interact
// with each other, colliders and sleeping bodies, because other islands may run on other threads.
void solve_with_detections(RigidIsland& island, std::span<const Collider> colliders, double gravity_m_s2,
                           double duration_s, int parts) {
  const double part_s = duration_s / parts;
  std::vector<const RigidBody*> members(island.bodies.begin(), island.bodies.end());
  std::ranges::sort(members);
  const auto elsewhere = [&](const RigidBody* body) {
    return !body->asleep && !std::ranges::binary_search(members, body);
  };
  std::vector<std::vector<RigidBody*>> near;
  for (RigidBody* body : island.bodies) {
    near.push_back(body->near);
    std::erase_if(body->near, elsewhere);
    for (ContactManifold& manifold : body->manifolds) scale_impulses(manifold, 1.0 / parts);
    body->velocity_m_s = body->substep_velocity_m_s;
  }
  std::erase_if(island.contacts, [](const RigidIsland::Contact& contact) { return !contact.owner->asleep; });
  const size_t of_sleepers = island.contacts.size();
  for (int part = 0; part < parts; ++part) {
    for (RigidBody* body : island.bodies) {
      body->substep_velocity_m_s = body->velocity_m_s;
      body->velocity_m_s += part_s * body->substep_acceleration_m_s2;
    }
    for (RigidBody* body : island.bodies) find_contacts(*body, colliders, gravity_m_s2, part_s);
    island.contacts.resize(of_sleepers);
    for (RigidBody* body : island.bodies) {
      for (ContactManifold& manifold : body->manifolds) island.contacts.push_back({body, &manifold});
    }
    solve_island(island, part_s, kSolverSteps);
  }
  for (size_t i = 0; i < island.bodies.size(); ++i) {
    island.bodies[i]->near = std::move(near[i]);
    for (ContactManifold& manifold : island.bodies[i]->manifolds) scale_impulses(manifold, parts);
  }
}

}  // namespace

void step_rigid_bodies(std::span<RigidBody* const> bodies, std::span<const RigidLoad> loads,
                       std::span<const Collider> colliders, const Eigen::Vector3d& gravity_m_s2,
                       double duration_s, RigidBroadPhase& broad_phase) {
  if (std::ranges::all_of(bodies, &RigidBody::asleep)) return;
  if (wake_groups(bodies)) broad_phase.invalidate();
  std::vector<char> accelerated(bodies.size(), 0);
  const auto accelerate_awake = [&] {
    bool any = false;
    for (size_t i = 0; i < bodies.size(); ++i) {
      if (bodies[i]->asleep || accelerated[i]) continue;
      accelerate(*bodies[i], loads[i], gravity_m_s2, duration_s);
      accelerated[i] = any = true;
    }
    return any;
  };
  accelerate_awake();
  broad_phase.update(bodies, gravity_m_s2.norm(), duration_s);

  std::vector<RigidBody*> active;  // awake, or owner of a pair with an awake body
  for (RigidBody* body : bodies) {
    if (!body->asleep || !std::ranges::all_of(body->near, &RigidBody::asleep)) active.push_back(body);
  }
  parallel_for(active.size(), 8, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      find_contacts(*active[i], colliders, gravity_m_s2.norm(), duration_s);
  });
  if (wake_on_contact(active, duration_s)) {
    // Woken bodies reuse the contacts from before they slept.
    wake_groups(bodies);
    broad_phase.invalidate();
    accelerate_awake();
    active.clear();
    for (RigidBody* body : bodies) {
      const auto may_touch_awake = [](const ContactManifold& manifold) {
        return manifold.other && !manifold.other->asleep;
      };
      if (!body->asleep || std::ranges::any_of(body->manifolds, may_touch_awake)) active.push_back(body);
    }
  }

  std::vector<RigidIsland> islands = rigid_islands(active, IslandLink::AnyManifold, gravity_m_s2);
  parallel_for(islands.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const StepPlan plan = plan_steps(islands[i], gravity_m_s2, duration_s, kSolverSteps);
      if (plan.detections == 1) {
        solve_island(islands[i], duration_s, plan.steps);
      } else {
        solve_with_detections(islands[i], colliders, gravity_m_s2.norm(), duration_s, plan.detections);
      }
    }
  });
}

}  // namespace livegs
