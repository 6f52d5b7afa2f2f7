// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <utility>
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

// Internal state of a World. Maps are ordered, so that sums over objects are in ascending id.

namespace livegs {

struct StaticObject {
  Pose world_from_object;
  Material material;
};

struct RigidObject {
  std::vector<std::unique_ptr<RigidBody>> bodies;  // by body_index: the whole object, or its fragments
  Material material;

  // Pieces of fragile objects; nullptr until they are prepared.
  std::shared_ptr<const BreakablePieces> pieces;
  BondGraph bonds;                     // current bonds, if there are pieces
  std::vector<uint32_t> piece_bodies;  // body_index of each piece; empty until it breaks
  uint32_t revision = 0;               // number of fractures

  uint32_t body_of(uint32_t piece) const { return piece_bodies.empty() ? 0 : piece_bodies[piece]; }
  // Body that contains a material point (object frame at rest), by `piece` if given.
  RigidBody& body_with(const Eigen::Vector3d& rest_point_m, std::optional<uint32_t> piece = {}) const {
    if (piece_bodies.empty()) return *bodies[0];
    return *bodies[body_of(piece && *piece < piece_bodies.size() ? *piece
                                                                 : pieces->cut.locate(rest_point_m))];
  }
  // Piece of a body whose triangles are nearest to a point (object frame at rest); nullopt while the object
  // is whole. Used by grabs.
  std::optional<uint32_t> piece_nearest_to(size_t body_index, const Eigen::Vector3d& rest_point_m) const;
};

struct ElasticObject {
  std::unique_ptr<ElasticBody> body;
  std::vector<Eigen::Vector3d> rest_particles_m;  // object frame
  uint32_t object_id = 0;
  bool stepped = false;  // in this tick, by the device
  // Per-substep data, separate for each body because bodies run on different threads.
  std::vector<RigidProxy*> near_bodies;
  std::vector<ElasticNeighbour> near_elastic;
  std::vector<PointForce> forces;
  std::vector<ContactConstraint> contact_rows;  // of one step
  // Ids (body_id_of, ascending) of bodies in contact during the last tick while awake. They sleep and wake
  // together.
  std::vector<uint64_t> contacts_last_tick, contacts_this_tick;
  double last_tick_contact_impulse_n_s = 0;  // from all contacts of the last tick
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
  void sleep();
};

struct ActiveForce {
  uint32_t object_id = 0;
  PointForce force;
  double end_s = 0.0;
};

struct ActiveSpring {
  uint32_t object_id = 0;
  World::Spring spring;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // in the last substep
  RigidSpring row;                                    // rigid objects; includes the force
  PointSpring point = {};                             // elastic objects
};

// One point of an elastic object held by a hand.
struct GripPoint {
  Eigen::Vector3d rest_point_m;
  Eigen::Vector3d hand_point_m;  // target position, hand frame
  PointSpring point = {};
};

struct ActiveGrab {
  uint32_t object_id = 0;
  World::Grip grip;
  Eigen::Vector3d rest_point_m;
  std::optional<uint32_t> piece;  // broken objects only
  Pose world_from_hand;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
  // Extrapolation from the last update; time since the last update.
  double extrapolation_s = 0, since_update_s = 0;
  Eigen::Quaterniond hand_from_object = Eigen::Quaterniond::Identity();
  RigidSpring row;                                    // rigid objects
  std::vector<GripPoint> grip_points;                 // elastic objects
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  // elastic objects, in the last substep
};

struct ActiveJoint {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;           // the other object if it moves
  std::optional<uint32_t> declared_id;        // as described by the caller
  Eigen::Vector3d point_m, axis;              // object frame, at rest
  Eigen::Vector3d other_point_m, other_axis;  // in the frame of the other object, or the world
  RigidJoint joint;                           // state when groups were last built
  const JointGroup* group = nullptr;
};

struct World::State {
  WorldSettings settings;
  std::vector<Collider> colliders;
  std::vector<uint32_t> collider_objects;  // of each collider: the static object that it belongs to; 0: none
  std::map<uint32_t, WorldObject> objects;
  std::map<uint64_t, ActiveForce> forces;
  std::map<uint64_t, ActiveSpring> springs;
  std::map<uint64_t, ActiveGrab> grabs;
  std::vector<ActiveJoint> joints;  // in the order of adding; ids start at 1
  std::vector<std::unique_ptr<JointGroup>> joint_groups;
  std::vector<WorldEvent> events;  // pending
  uint64_t tick = 0;
  StepTimes times;

  // Views of `objects` in ascending id, rebuilt when it changes.
  std::vector<std::pair<uint32_t, WorldObject*>> listed_objects;  // faster to go through than the map
  std::vector<RigidBody*> rigid_bodies;
  std::vector<ElasticObject*> elastic_objects;
  std::vector<RigidLoad> loads;
  RigidBroadPhase broad_phase;
  // For each rigid body: its proxy for elastic bodies, and its velocity change in the last substep without
  // the impulses of elastic bodies.
  std::vector<RigidProxy> rigid_proxies;
  struct VelocityChange {
    Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero(), spin_rad_s = Eigen::Vector3d::Zero();
  };
  std::vector<VelocityChange> velocity_changes;

  WorldObject* find(uint32_t object_id);
  Result<RigidObject*> find_rigid(uint32_t object_id);
  // Index in rigid_bodies of a body; their number for an unknown id.
  size_t rigid_index(uint64_t body_id) const;
  Result<void> add(const RigidBodyDescription& checked);
  void list_bodies();
  void wake_all();
  // Wakes bodies that touch the object, and drops the contacts with it.
  void end_contacts_of(uint32_t object_id);
  Result<void> add_joint(const HingeJointDescription& description, bool hinge);
  void link_joints();  // rebuilds joint groups after joints or bodies changed
  const RigidJoint& running(const ActiveJoint& held) const;

  void clear_ended_forces(double now_s);
  void gather_loads(double start_s, double duration_s);
  void gather_springs(double duration_s);  // of set_spring() and grabs
  // At the first fracture of an object, assigns to each grab of it the nearest piece.
  void assign_grabs_to_pieces(uint32_t object_id, const RigidObject& object);
  // On the device, if there is one.
  void step_on_device(double start_s, double tick_s);
  void step_elastic(double start_s, double duration_s);
  void step_rigid(double duration_s);
  // world_coupling.cpp. Elastic bodies that may touch each other step together. The result groups those that
  // share a rigid body; the sets of a group step one after another.
  using CoupledBodies = std::vector<ElasticObject*>;
  std::vector<std::vector<CoupledBodies>> build_elastic_groups(double duration_s);
  void apply_elastic_impulses(double duration_s);
  void wake_islands();
  bool wake_body(uint64_t body_id, bool awake);
  void sleep_islands(double tick_s);
  void report_contacts();
  // Kinetic and potential energy of a rigid body.
  double energy_j(const RigidBody& body) const;
  // Energy lost since the start of the tick by the body and its possible contacts.
  double local_energy_loss_j(const RigidBody& body) const;
  // Fractures bodies above their threshold, at the end of a tick.
  void process_impacts();
  // Applies an impact to one body. Returns whether the body came apart. First removes the fraction
  // `undone_fraction` of the contact impulses, limited so that its energy does not exceed that at the start
  // of the tick. Fragments then receive the kinetic energy `recoil_j`, limited to kRecoilEnergyFraction of
  // local_energy_loss_j().
  bool fracture_body(uint32_t object_id, RigidObject& object, uint32_t body_index, const Impact& impact,
                     const ImpulseAccumulator& given, double undone_fraction, double recoil_j);
  // Creates a body for each group of pieces (at least two groups, which together are the body). The largest
  // group keeps the index.
  void split_body(uint32_t object_id, RigidObject& object, uint32_t body_index,
                  const std::vector<std::vector<uint32_t>>& groups);
  void report_sleep();
};

}  // namespace livegs
