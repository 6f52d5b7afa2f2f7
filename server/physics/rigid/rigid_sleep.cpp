// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/rigid_sleep.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/motion/lasting_time.h"
#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/joint/joint_group.h"
#include "physics/rigid/rigid_islands.h"

namespace livegs {
namespace {

// Of the centre of mass and two points at right angles on the bounding sphere.
double three_point_speed_m_s(const RigidBody& body) {
  const Eigen::Matrix3d axes = body.world_from_body.orientation.toRotationMatrix();
  const auto speed = [&](int axis) {
    return body.point_velocity(body.shape.bounding_radius_m * axes.col(axis)).norm();
  };
  return std::max({body.velocity_m_s.norm(), speed(0), speed(1)});
}

}  // namespace

double sleep_speed_m_s(const RigidShape& shape) {
  return kSleepSpeed_m_s * std::sqrt(std::min(1.0, 2.0 * shape.bounding_radius_m));
}

void update_sleep(std::span<RigidBody* const> bodies, double tick_s, RigidBroadPhase& broad_phase) {
  std::vector<RigidBody*> awake;
  for (RigidBody* body : bodies) {
    if (body->asleep) continue;
    awake.push_back(body);
    bool touching = body->pushed_by_owner || body->in_elastic_contact || body->joints;
    for (const ContactManifold& manifold : body->manifolds)
      touching = touching || total_impulse(manifold) > 0.0;
    const bool still = touching && three_point_speed_m_s(*body) < sleep_speed_m_s(body->shape);
    body->still_s = still ? body->still_s + tick_s : 0.0;
  }
  for (RigidIsland& island : rigid_islands(awake, IslandLink::TouchingManifold, Eigen::Vector3d::Zero())) {
    const bool still = std::ranges::all_of(island.bodies, [](const RigidBody* body) {
      return body->still_s >= kLastingTime_s && !body->island_awake;
    });
    if (!still) continue;
    for (RigidBody* body : island.bodies) body->sleep(island.bodies.front()->body_id() + 1);
    broad_phase.invalidate();
  }
}

bool wake_groups(std::span<RigidBody* const> bodies) {
  for (RigidBody* body : bodies) {
    if (!body->asleep && body->joints) body->joints->wake_together();
  }
  std::vector<uint64_t> woken;
  for (RigidBody* body : bodies) {
    if (body->asleep || body->sleep_group == 0) continue;
    woken.push_back(body->sleep_group);
    body->sleep_group = 0;
  }
  if (woken.empty()) return false;
  for (RigidBody* body : bodies) {
    if (!body->asleep || std::ranges::find(woken, body->sleep_group) == woken.end()) continue;
    body->wake();
    body->sleep_group = 0;
  }
  return true;
}

}  // namespace livegs
