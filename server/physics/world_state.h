// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <variant>
#include <vector>

#include "physics/rigid_body.h"
#include "physics/rigid_step.h"
#include "physics/world.h"

// The inside of a World. Maps are ordered: every sum over objects is in ascending id.

namespace livegs {

// Events nobody takes are forgotten from the oldest on.
inline constexpr size_t kMaxKeptEvents = 65536;

struct StaticObject {
  Pose world_from_object;
  Material material;
};

struct RigidObject {
  std::unique_ptr<RigidBody> body;
  Eigen::Vector3d centre_of_mass_m = Eigen::Vector3d::Zero();  // object frame: object_from_body
  Material material;
};

struct ElasticObject {
  std::unique_ptr<ElasticBody> body;
  double reach_m = 0;  // no particle at rest is farther from the centre of mass
  // Of one substep, in its own memory so that bodies can run on different threads.
  std::vector<MovingSphere> spheres;
  std::vector<RigidBody*> sphere_owners;
  std::vector<PointForce> forces;
  // Over the tick, from balls and colliders.
  double contact_impulse_n_s = 0;
  Eigen::Vector3d contact_moment = Eigen::Vector3d::Zero();
};

struct WorldObject {
  std::variant<StaticObject, RigidObject, ElasticObject> thing;
  bool reported_asleep = false;

  StaticObject* fixed() { return std::get_if<StaticObject>(&thing); }
  RigidObject* rigid() { return std::get_if<RigidObject>(&thing); }
  ElasticObject* elastic() { return std::get_if<ElasticObject>(&thing); }
  const StaticObject* fixed() const { return std::get_if<StaticObject>(&thing); }
  const RigidObject* rigid() const { return std::get_if<RigidObject>(&thing); }
  const ElasticObject* elastic() const { return std::get_if<ElasticObject>(&thing); }
  bool asleep() const;
  void wake();
};

struct HeldForce {
  uint32_t object_id = 0;
  PointForce force;
};

struct HeldSpring {
  uint32_t object_id = 0;
  World::Spring spring;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // of the last substep
};

struct World::State {
  WorldSettings settings;
  std::vector<Collider> colliders;
  std::map<uint32_t, WorldObject> objects;
  std::map<uint64_t, HeldForce> forces;
  std::map<uint64_t, HeldSpring> springs;
  std::vector<WorldEvent> events;
  uint64_t tick = 0;
  StepTimes times;

  // Views of `objects`, ascending id; made again when it changes.
  std::vector<RigidBody*> rigid_bodies;
  std::vector<ElasticObject*> elastic_objects;
  std::vector<RigidLoad> loads;

  WorldObject* find(uint32_t object_id);
  const WorldObject* find(uint32_t object_id) const;
  void list_bodies();
  void wake_all();

  void gather_loads(double duration_s);
  void meet_balls(ElasticObject& elastic, double duration_s);
  void step_elastic(double start_s, double duration_s);
  void report_contacts();
  void report_sleep();
};

}  // namespace livegs
