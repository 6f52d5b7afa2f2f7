// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/triangle_mesh.h"
#include "physics/breakable_pieces.h"
#include "physics/collider.h"
#include "physics/elastic_body.h"
#include "physics/material.h"
#include "skin/driver_frame.h"
#include "skin/rest_body.h"

// Everything that moves, and the one substep loop that moves it. One thread owns a World; nothing in it
// locks. step() uses several threads inside, and gives the same bits for any number of them.

namespace livegs {

struct WorldSettings {
  Eigen::Vector3d gravity_m_s2{0, -9.81, 0};
  double rate_hz = 90.0;  // ticks a second
  int substeps = 4;       // a tick
  ElasticSolver elastic_solver = ElasticSolver::Cells;
  bool sleep = true;
  double elastic_node_substeps = kMaxNodeSubsteps;  // a tick, of all elastic bodies (elastic_budget.h)
};

struct RigidBodyDescription {
  uint32_t object_id = 0;
  TriangleMesh mesh;          // object frame; closed
  MassProperties properties;  // of 1 kg, object frame
  // > 0: it is a sphere about its centre of mass and touches as one; the mesh is what breaks.
  double sphere_radius_m = 0.0;
  Material material;
  Pose world_from_object;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();            // world frame, of the centre of mass
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // world frame
};

struct BallDescription {
  uint32_t object_id = 0;
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  double radius_m = 0.03;
  double mass_kg = 0.1;
  double friction = 0.4;
  double restitution = 0.6;
};

// A joint of a rigid object to the world, or to another rigid object. Points and directions are in the first
// object's frame at rest; the joint is closed as the objects stand when it is added. The two do not touch
// each other.
struct BallJointDescription {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;  // none, or an object that never moves: the world
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};
struct HingeJointDescription {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // any length but zero
};

// A joint now. Errors are what is left of it: the distance of its two points, the angle between its two axes.
struct JointState {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;
  bool hinge = false;
  Eigen::Vector3d point_m, axis;  // world; axis is zero for a ball joint
  double error_m = 0, error_rad = 0;
  double force_n = 0;  // that it bears, on average over the last substep
};

// One row of bodies.csv.
struct BodyState {
  uint32_t object_id = 0;
  uint32_t body_index = 0;  // within the object: 0 until it breaks
  Pose world_from_body;     // the body's origin is its centre of mass, axes parallel to the object's at rest
  Eigen::Vector3d velocity_m_s, angular_velocity_rad_s;
  double mass_kg = 0;
  bool asleep = false;
};

enum class WorldEventKind { Contact, Sleep, Wake, Fracture };
struct WorldEvent {
  uint64_t tick = 0;
  WorldEventKind kind = WorldEventKind::Contact;
  uint32_t object_id = 0;
  double impulse_n_s =
      0;  // Contact: from other objects, summed over the tick, when above kReportedImpulse. Fracture: of
          // impacts within 1/60 s and of what lasted, see rigid_blow.h; 0 when broken at will
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};

struct RayHit {
  uint32_t object_id = 0;
  double distance_m = 0;
  Eigen::Vector3d rest_point_m;  // object frame, at rest
  std::optional<uint32_t>
      piece;  // of a broken object, one of the fragment that was met, the nearest to the point
};

// Wall times of the last step, milliseconds.
struct StepTimes {
  double rigid_ms = 0, elastic_ms = 0, total_ms = 0;
};

class World {
 public:
  explicit World(const WorldSettings& settings);
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  const WorldSettings& settings() const;

  // Ids are the caller's and unique; errors name the object's id and what is not physical.
  void add_collider(const Collider& collider);
  Result<void> add_static(uint32_t object_id, const Pose& world_from_object);
  Result<void> add_rigid(const RigidBodyDescription& description);
  Result<void> add_elastic(const ElasticBodyDescription& description);
  Result<void> add_ball(const BallDescription& description);
  // Balls that have gone far; unknown ids are ignored. Forces and springs on it, and hands that hold it, go
  // with it.
  void remove(uint32_t object_id);

  // Errors name the objects. A joint goes when an object of it is removed.
  Result<void> add_ball_joint(const BallJointDescription& description);
  Result<void> add_hinge_joint(const HingeJointDescription& description);
  std::vector<JointState> joints() const;  // in the order they were added

  // One tick: 1 / rate_hz seconds.
  void step();
  uint64_t tick() const;

  // A constant force (world frame) on a material point (rest object frame) from now until cleared. Ids are
  // the caller's; setting one again replaces it. A force on an unknown object is ignored.
  void set_force(uint64_t force_id, uint32_t object_id, const PointForce& force);
  void clear_force(uint64_t force_id);
  // A material point is told by its place in the object at rest. Of a broken object it moves with the
  // fragment that has `piece`, or, if none is told, the piece at that place: a point beside a surface, as a
  // hand's is, may lie in the cell of another fragment than the one it was met with.

  // A spring of constant stiffness from a material point to a world point, damped critically for the mass it
  // feels, its force bounded by max_force_n. Evaluated every substep.
  struct Spring {
    Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero(), target_m = Eigen::Vector3d::Zero();
    double stiffness_n_m = 50.0, max_force_n = 50.0;
    std::optional<uint32_t> piece = {};
  };
  void set_spring(uint64_t spring_id, uint32_t object_id, const Spring& spring);
  void clear_spring(uint64_t spring_id);
  // The force a spring applied in the last substep, for the arrow a client draws; zero when there is none.
  Eigen::Vector3d spring_force_n(uint64_t spring_id) const;

  // A hand closes on an object: from now on springs draw the material that is at the hand's place to where
  // the hand is, and turn the object as the hand turns, from how both are now, so that nothing moves at
  // first. Force and torque are bounded, wherever the hand goes. Of a broken object it holds the fragment
  // whose surface is nearest, and of what breaks in the hand the one with the nearest piece. On an elastic
  // object a few points about the hand are held instead of its orientation. Several hands may hold one
  // object. Ids are the caller's, apart from those of set_spring; an id that is in use lets go first.
  struct Grip {
    double frequency_hz = 8.0;  // of the object's whole mass on the springs, in air
    double max_force_n = 50.0, max_torque_n_m = 5.0;
  };
  Result<void> grab(uint64_t grab_id, uint32_t object_id, const Pose& world_from_hand, const Grip& grip);
  // Where the hand is at the start of the next tick, and how it moves for `extrapolation_s` from then, at
  // least during that tick: the time until it is likely to be heard of again. Then it stands. Not finite:
  // ignored. Unknown ids are ignored too. What is let go flies on as it moves then.
  void move_grab(uint64_t grab_id, const Pose& world_from_hand, const Eigen::Vector3d& velocity_m_s,
                 const Eigen::Vector3d& spin_rad_s, double extrapolation_s = 0.0);
  void release_grab(uint64_t grab_id);
  struct GrabState {
    Eigen::Vector3d point_m;  // the material point that was at the hand's place, now
    Eigen::Vector3d force_n,
        torque_n_m;  // on the object, in the last substep; an elastic one has no torque of its own
    std::optional<uint32_t> piece;  // of a broken object: it holds the fragment that has this one
  };
  std::optional<GrabState> grab_state(uint64_t grab_id) const;  // nothing: it holds nothing (any more)

  // The sum of the sizes of the impulses that contacts gave in the last tick, N s, to the body that has this
  // point (rest object frame): the fragment of a broken object, else the whole. Resting is a contact.
  double contact_impulse_n_s(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                             std::optional<uint32_t> piece = {}) const;
  // Of that body, kg: what a hand that holds the point has to move. 0 for static and unknown objects.
  double mass_at_kg(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                    std::optional<uint32_t> piece = {}) const;

  // The object that is nearest to a point and no farther than `reach_m`, static ones left out; `distance_m`
  // is 0 inside. The rest point is the very point, beside the surface or not.
  std::optional<RayHit> nearest(const Eigen::Vector3d& point_m, double reach_m) const;
  // The same of one object, however far it is: what grab() would hold. Nothing for static and unknown ones.
  std::optional<RayHit> nearest_of(uint32_t object_id, const Eigen::Vector3d& point_m) const;

  // What a ray from `origin_m` along the unit `direction` meets first within `max_distance_m`. Nothing where
  // that is a collider or what stands still; those that hold `origin_m` are looked through.
  std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                 double max_distance_m) const;
  // Where a material point is now; the rest point itself for an unknown object.
  Eigen::Vector3d world_point(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                              std::optional<uint32_t> piece = {}) const;

  // Lets go of a fixed or moved region of an elastic object for good. Fails if there is none of that name.
  Result<void> release_region(uint32_t object_id, const std::string& region);
  // The same behaviour only. Of an elastic object the cells stay, and its substeps keep to what others leave
  // of elastic_node_substeps, or to an equal part of it if that is more. A rigid object that is fragile or
  // has pieces needs a break_impulse_n_s of 1e-6 to 1e6.
  Result<void> set_material(uint32_t object_id, const Material& material);
  const Material* material(uint32_t object_id) const;

  // What a rigid object can break into (of the very mesh and fill it was added with); until then it does not
  // break. From now on it does, if it is fragile, when the impulses of impacts on it, summed over 1/60 s
  // wherever ticks end, with those of a millisecond of what lasts reach material().break_impulse_n_s: see
  // rigid_blow.h. Its fragments break again, down to single pieces.
  Result<void> set_pieces(uint32_t object_id, std::shared_ptr<const BreakablePieces> pieces);
  // Breaks it at a material point (rest object frame) as an impact of kForcedBreakFactor times what it bears
  // would, without giving it any momentum. Fails, and says why, if there is nothing to break there.
  Result<void> break_object(uint32_t object_id, const Eigen::Vector3d& rest_point_m);
  // The body (BodyState::body_index) of each piece; empty until the object breaks.
  std::span<const uint32_t> piece_bodies(uint32_t object_id) const;
  uint32_t revision(uint32_t object_id) const;  // how often the object has broken

  // Without object_from_asset, which the scene fills in. Precondition: the object exists.
  RestBody rest_body(uint32_t object_id) const;
  DriverFrame drivers() const;  // objects in ascending id
  std::vector<BodyState> bodies() const;
  const ElasticBody* elastic_body(uint32_t object_id) const;  // nullptr if it is not elastic
  BodyEnergy energy() const;
  std::vector<WorldEvent> take_events();
  StepTimes last_times() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Contacts weaker than this over a tick are not reported as events.
inline constexpr double kReportedImpulse_n_s = 0.02;

inline constexpr double kForcedBreakFactor = 2.5;

}  // namespace livegs
