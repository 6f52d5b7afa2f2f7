// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <variant>
#include <vector>

#include "physics/breakable_pieces.h"
#include "physics/elastic/rigid_proxy.h"
#include "physics/fracture/bond_graph.h"
#include "physics/rigid/joint/joint_group.h"
#include "physics/rigid/rigid_body.h"
#include "physics/rigid/rigid_spring.h"
#include "physics/rigid/rigid_step.h"
#include "physics/world.h"

// The inside of a World. Maps are ordered: every sum over objects is in ascending id.

namespace livegs {

// Events nobody takes are forgotten from the oldest on.
inline constexpr size_t kMaxEvents = 65536;

struct StaticObject {
  Pose world_from_object;
  Material material;
};

struct RigidObject {
  std::unique_ptr<RigidBody> body;  // the whole; once it is broken, the fragment with body_index 0
  std::vector<std::unique_ptr<RigidBody>> fragments;  // the others, body_index 1, 2, …
  Material material;

  // Fragile objects: what they can break into, nullptr until it is prepared.
  std::shared_ptr<const BreakablePieces> pieces;
  BondGraph bonds;                     // as they are now, if there are pieces
  std::vector<uint32_t> piece_bodies;  // body_index of each piece; empty until it breaks
  uint32_t revision = 0;               // counts its breaks

  uint32_t body_of(uint32_t piece) const { return piece_bodies.empty() ? 0 : piece_bodies[piece]; }
  size_t body_count() const { return 1 + fragments.size(); }
  RigidBody& body_at(size_t index) { return index == 0 ? *body : *fragments[index - 1]; }
  const RigidBody& body_at(size_t index) const { return index == 0 ? *body : *fragments[index - 1]; }
  // The one that holds a material point (object frame, at rest): of the piece, if one is told.
  RigidBody& body_with(const Eigen::Vector3d& rest_point_m, std::optional<uint32_t> piece = {}) {
    return body_at(index_with(rest_point_m, piece));
  }
  const RigidBody& body_with(const Eigen::Vector3d& rest_point_m, std::optional<uint32_t> piece = {}) const {
    return body_at(index_with(rest_point_m, piece));
  }
  size_t index_with(const Eigen::Vector3d& rest_point_m, std::optional<uint32_t> piece) const {
    if (piece_bodies.empty()) return 0;
    return body_of(piece && *piece < piece_bodies.size() ? *piece : pieces->cut.locate(rest_point_m));
  }
  // For hands: the piece of a body whose surface is nearest to a point (object frame, at rest), by its
  // triangles; none while the object is whole.
  std::optional<uint32_t> piece_nearest_to(size_t body_index, const Eigen::Vector3d& rest_point_m) const;
};

struct ElasticObject {
  std::unique_ptr<ElasticBody> body;
  std::vector<Eigen::Vector3d> rest_particles_m;  // object frame
  uint32_t object_id = 0;
  // Of one substep, in its own memory so that bodies can run on different threads.
  std::vector<RigidProxy*> near_bodies;
  std::vector<ElasticNeighbour> near_elastic;
  std::vector<PointForce> forces;
  // Bodies it pushed in the last tick it was awake, by body_id_of, ascending: they sleep and wake together.
  std::vector<uint64_t> contacts_last_tick, contacts_this_tick;
  // Over the tick, from everything it touches.
  double contact_impulse_n_s = 0;
  Eigen::Vector3d contact_moment = Eigen::Vector3d::Zero();
  double last_tick_contact_impulse_n_s = 0;  // contact_impulse_n_s of the last tick
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

struct ActiveForce {
  uint32_t object_id = 0;
  PointForce force;
};

struct ActiveSpring {
  uint32_t object_id = 0;
  World::Spring spring;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // of the last substep
  RigidSpring row;                                    // of a rigid object; with its own force
  PointSpring point = {};                             // of an elastic one
};

// What a hand holds of an elastic object: one of the points near it.
struct GripPoint {
  Eigen::Vector3d rest_point_m;
  Eigen::Vector3d hand_point_m;  // where it belongs, in the hand's frame
  PointSpring point = {};
};

struct ActiveGrab {
  uint32_t object_id = 0;
  World::Grip grip;
  Eigen::Vector3d rest_point_m;
  std::optional<uint32_t> piece;  // of an object that has broken
  Pose world_from_hand;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
  double extrapolation_s = 0, since_update_s = 0;  // from when it was set, and since
  Eigen::Quaterniond hand_from_object = Eigen::Quaterniond::Identity();
  RigidSpring row;                                    // of a rigid object
  std::vector<GripPoint> grip_points;                 // of an elastic one
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // of an elastic one, in the last substep
};

struct ActiveJoint {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;           // of an object that moves
  std::optional<uint32_t> declared_id;        // as it was given
  Eigen::Vector3d point_m, axis;              // object frame, at rest
  Eigen::Vector3d other_point_m, other_axis;  // of the other object, or of the world
  RigidJoint joint;                           // as it was when groups were last made
  const JointGroup* group = nullptr;
};

struct World::State {
  WorldSettings settings;
  std::vector<Collider> colliders;
  std::map<uint32_t, WorldObject> objects;
  std::map<uint64_t, ActiveForce> forces;
  std::map<uint64_t, ActiveSpring> springs;
  std::map<uint64_t, ActiveGrab> grabs;
  std::vector<ActiveJoint> joints;  // as they were added; ids count from 1
  std::vector<std::unique_ptr<JointGroup>> joint_groups;
  std::vector<WorldEvent> events;
  uint64_t tick = 0;
  StepTimes times;

  // Views of `objects`, ascending id; made again when it changes.
  std::vector<RigidBody*> rigid_bodies;
  std::vector<ElasticObject*> elastic_objects;
  std::vector<RigidLoad> loads;
  RigidBroadPhase broad_phase;
  // Of each rigid body: its copy for elastic ones, and how its velocities changed in the last substep,
  // without what elastic ones gave it.
  std::vector<RigidProxy> rigid_proxies;
  struct VelocityChange {
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
  };
  std::vector<VelocityChange> velocity_changes;

  WorldObject* find(uint32_t object_id);
  const WorldObject* find(uint32_t object_id) const;
  void list_bodies();
  void wake_all();
  Result<void> add_joint(const HingeJointDescription& description, bool hinge);
  void link_joints();  // groups of the joints there are, after joints or bodies came or went
  const RigidJoint& running(const ActiveJoint& held) const;

  void gather_loads(double duration_s);
  void gather_springs(double duration_s);  // of hands
  // Hands that hold an object as it breaks for the first time: each the piece beside it.
  void assign_grabs_to_pieces(uint32_t object_id, const RigidObject& object);
  void step_elastic(double start_s, double duration_s);
  void step_rigid(double duration_s);
  // world_contact.cpp
  // Elastic bodies that may touch each other step together; groups of those that share a rigid body, one
  // after another.
  using CoupledBodies = std::vector<ElasticObject*>;
  std::vector<std::vector<CoupledBodies>> build_elastic_groups(double duration_s);
  void apply_elastic_impulses(double duration_s);
  void wake_islands();
  bool wake_body(uint64_t body_id, bool awake);
  void sleep_islands(double tick_s);
  void report_contacts();
  // Of the motion of a rigid body, and its weight's.
  double energy_j(const RigidBody& body) const;
  // What it and those that it can have met in this tick have lost since the tick began.
  double local_energy_loss_j(const RigidBody& body) const;
  // At the end of a tick: what was struck hard enough comes apart.
  void process_impacts();
  // Breaks what an impact on one body breaks. Returns whether the body came apart.
  // The part `undone_fraction` of what contacts gave it is taken from it first, never beyond the energy it
  // began the tick with; `recoil_j`, as far as it and what it met have lost ten times as much, drives the
  // fragments apart.
  bool fracture_body(uint32_t object_id, RigidObject& object, uint32_t body_index, const Impact& impact,
                     const ImpulseAccumulator& given, double undone_fraction, double recoil_j);
  // Makes a body of each group of pieces (at least two groups, together all of the body's); the largest keeps
  // the index.
  void split_body(uint32_t object_id, RigidObject& object, uint32_t body_index,
                  const std::vector<std::vector<uint32_t>>& groups);
  void report_sleep();
};

}  // namespace livegs
