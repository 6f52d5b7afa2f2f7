// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
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
#include "physics/surface_friction.h"
#include "skin/driver_frame.h"
#include "skin/rest_body.h"

// The simulated world and its substep loop. One thread owns a World; there are no locks. step() uses several
// threads internally, and its result does not depend on their number.

namespace livegs {

struct RigidShape;  // collision/collision_shape.h

// Longest substep. Longer: bodies that topple or roll pass their contacts, which are found once a substep.
inline constexpr double kMaxSubstep_s = 1.0 / 30.0;

struct WorldSettings {
  Eigen::Vector3d gravity_m_s2{0, -9.81, 0};
  double rate_hz = 90.0;                                // ticks per second
  int substeps = 4;                                     // per tick; raised to min_substeps() if fewer
  ElasticBodyFactory make_elastic = make_elastic_body;  // the solver of elastic bodies
  bool sleep = true;
  // Per tick, all elastic bodies together (share_elastic_budget.h).
  double elastic_node_substeps = kMaxNodeSubsteps;
};

int min_substeps(double rate_hz);  // so that none is longer than kMaxSubstep_s

struct RigidBodyDescription {
  uint32_t object_id = 0;
  TriangleMesh mesh;  // object frame; closed
  // Contact shape of the mesh about the centre of mass (prepare_body); null: add_rigid makes it.
  std::shared_ptr<const RigidShape> shape;
  MassProperties properties;  // per kg, object frame
  // > 0: a sphere about the centre of mass for contact; the mesh is only used for fracture.
  double sphere_radius_m = 0.0;
  // The exact surface of a cylinder or capsule, in the object frame; the mesh may have facets.
  std::optional<RoundShape> round;
  Material material;
  std::vector<FrictionBox> friction_boxes;  // parts of other friction; empty: that of the material everywhere
  Pose world_from_object;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();            // world frame, of the centre of mass
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // world frame
};

struct BallDescription {
  uint32_t object_id = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  double radius_m = 0.03;
  double mass_kg = 0.1;
  double friction = 0.4;
  double restitution = 0.6;
};

// A joint of a rigid object to the world or to another rigid object. Points and directions are in the first
// object's frame at rest. The joint is closed in the poses at the time of adding. Contact between the two
// objects is disabled.
struct BallJointDescription {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;  // none or a static object: the world
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};
struct HingeJointDescription {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  // any non-zero length
};

// Current state of a joint. The errors are the distance of its two points and the angle between its two axes.
struct JointState {
  uint32_t object_id = 0;
  std::optional<uint32_t> other_id;
  bool hinge = false;
  Eigen::Vector3d point_m, axis;  // world frame; axis is zero for a ball joint
  double error_m = 0, error_rad = 0;
  double force_n = 0;  // mean over the last substep
};

// One row of bodies.csv.
struct BodyState {
  uint32_t object_id = 0;
  uint32_t body_index = 0;  // within the object; 0 until it breaks
  Pose world_from_body;     // origin: centre of mass; axes parallel to the object's at rest
  Eigen::Vector3d velocity_m_s, angular_velocity_rad_s;
  double mass_kg = 0;
  bool asleep = false;
};

enum class WorldEventKind { Contact, Sleep, Wake, Fracture };
struct WorldEvent {
  uint64_t tick = 0;
  WorldEventKind kind = WorldEventKind::Contact;
  uint32_t object_id = 0;
  // Contact: impulse from other objects, summed over the tick, if above kReportedImpulse_n_s. Fracture:
  // impulse of impacts within 1/60 s and of sustained loads (impact_record.h); 0 after break_object().
  double impulse_n_s = 0;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
};

struct RayHit {
  uint32_t object_id = 0;
  double distance_m = 0;
  Eigen::Vector3d rest_point_m;  // object frame, at rest
  // Broken objects only: the piece of the hit fragment that is nearest to the point.
  std::optional<uint32_t> piece;
};

// Wall-clock times of the last step, milliseconds.
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

  // The caller chooses ids; they must be unique. Errors name the object's id and the invalid value.
  // `object_id`: of the static object that the collider belongs to; 0: none.
  void add_collider(const Collider& collider, uint32_t object_id = 0);
  // Removes the colliders of a static object, or with 0 those without an object. Bodies on them wake up.
  void remove_colliders(uint32_t object_id);
  Result<void> add_static(uint32_t object_id, const Pose& world_from_object);
  Result<void> add_rigid(const RigidBodyDescription& description);
  Result<void> add_elastic(const ElasticBodyDescription& description);
  Result<void> add_ball(const BallDescription& description);
  // A body without velocity sleeps until it is touched, also before its first tick. No effect on other
  // objects.
  void put_to_sleep(uint32_t object_id);
  // Sets an object to its rest shape at a pose, with the motion of a rigid body (centre of mass, world
  // frame). The object and all bodies that touch it wake up. Fails for static and broken objects, and for
  // solvers that cannot.
  Result<void> place(uint32_t object_id, const Pose& world_from_object,
                     const Eigen::Vector3d& velocity_m_s = Eigen::Vector3d::Zero(),
                     const Eigen::Vector3d& angular_velocity_rad_s = Eigen::Vector3d::Zero());
  // Way that an object can go straight down, along gravity, until it meets a collider or another body, m. It
  // counts from the object's lowest points and is negative if they are inside. nullopt: nothing within
  // `max_distance_m`, no gravity, or no such object.
  std::optional<double> distance_down_m(uint32_t object_id, double max_distance_m) const;
  // The same for surface points (world frame) of an object that is not there yet, or is elsewhere now.
  std::optional<double> distance_down_m(std::span<const Eigen::Vector3d> points_m,
                                        std::optional<uint32_t> except_object_id,
                                        double max_distance_m) const;
  // Removes an object, for example a ball that is far away. Unknown ids are ignored. Forces, springs, grabs
  // and joints of the object are removed too, and the colliders of a static object.
  void remove(uint32_t object_id);

  // Errors name the objects. A joint is removed together with either of its objects.
  Result<void> add_ball_joint(const BallJointDescription& description);
  Result<void> add_hinge_joint(const HingeJointDescription& description);
  std::vector<JointState> joints() const;  // in the order of adding

  // Advances by one tick, 1 / rate_hz seconds.
  void step();
  uint64_t tick() const;

  // Applies a constant force (world frame) at a material point (object frame at rest) from the next tick on,
  // for `duration_s`, which may end within a substep. The caller chooses ids; an existing id is replaced.
  // Forces on unknown objects are ignored.
  void set_force(uint64_t force_id, uint32_t object_id, const PointForce& force,
                 double duration_s = std::numeric_limits<double>::infinity());
  // A material point is specified by its position in the object at rest. In a broken object it moves with the
  // fragment that contains `piece`, or without `piece` with the fragment at that position. Pass `piece` for
  // points near a surface, such as a hand's: they may lie in the cell of another fragment.

  // A spring of constant stiffness from a material point to a world point, critically damped for the
  // effective mass, with its force bounded by max_force_n. Evaluated every substep.
  struct Spring {
    Eigen::Vector3d rest_point_m = Eigen::Vector3d::Zero(), target_m = Eigen::Vector3d::Zero();
    double stiffness_n_m = 50.0, max_force_n = 50.0;
    std::optional<uint32_t> piece = {};
  };
  void set_spring(uint64_t spring_id, uint32_t object_id, const Spring& spring);
  void clear_spring(uint64_t spring_id);
  // Force of a spring in the last substep, for display; zero for unknown ids.
  Eigen::Vector3d spring_force_n(uint64_t spring_id) const;

  // Starts a grab: springs pull the material at the hand's position to the hand and rotate the object with
  // it. Offsets are taken from the current poses, so there is no initial motion. Force and torque are bounded
  // for any hand motion. A grab holds one body: in a broken object the fragment with the nearest surface, and
  // after a break in the hand the fragment with the nearest piece. An elastic object is held at a few points
  // near the hand instead of by its orientation. Several hands may hold one object. The caller chooses ids,
  // independent of those of set_spring; an id in use is released first.
  struct Grip {
    double frequency_hz = 8.0;  // natural frequency of the whole mass on the springs, in air
    double max_force_n = 50.0, max_torque_n_m = 5.0;
  };
  Result<void> grab(uint64_t grab_id, uint32_t object_id, const Pose& world_from_hand, const Grip& grip);
  // Pose of the hand at the start of the next tick and its velocity for `extrapolation_s` from then, at least
  // for that tick. Set it to the expected time until the next update; afterwards the hand stops. Non-finite
  // values and unknown ids are ignored.
  void move_grab(uint64_t grab_id, const Pose& world_from_hand, const Eigen::Vector3d& velocity_m_s,
                 const Eigen::Vector3d& spin_rad_s, double extrapolation_s = 0.0);
  void release_grab(uint64_t grab_id);  // the object keeps its velocity
  struct GrabState {
    Eigen::Vector3d point_m;  // current position of the material point at the hand
    // Force and torque on the object in the last substep; the torque of an elastic object is zero.
    Eigen::Vector3d force_n, torque_n_m;
    std::optional<uint32_t> piece;  // broken objects: a piece of the held fragment
  };
  std::optional<GrabState> grab_state(uint64_t grab_id) const;  // nullopt: no object is held

  // Sum of the magnitudes of the contact impulses of the last tick, N s, on the body with this point (object
  // frame at rest): a fragment of a broken object, or the whole object. Resting contacts count.
  double contact_impulse_n_s(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                             std::optional<uint32_t> piece = {}) const;
  // Mass of that body, kg. 0 for static and unknown objects.
  double mass_at_kg(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                    std::optional<uint32_t> piece = {}) const;

  // Nearest non-static object within `reach_m` of a point; `distance_m` is 0 inside. The rest point is the
  // queried point in the object frame; it is not projected onto the surface.
  std::optional<RayHit> nearest(const Eigen::Vector3d& point_m, double reach_m) const;
  // The same for one object at any distance: the body that grab() would hold. nullopt for static and unknown
  // ids.
  std::optional<RayHit> nearest_of(uint32_t object_id, const Eigen::Vector3d& point_m) const;

  // First object hit by the ray from `origin_m` along the unit `direction` within `max_distance_m`. nullopt
  // if a collider or a static object is hit first. Colliders that contain `origin_m` are ignored.
  std::optional<RayHit> ray_cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                 double max_distance_m) const;
  // Current position of a material point; the rest point itself for an unknown object.
  Eigen::Vector3d world_point(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                              std::optional<uint32_t> piece = {}) const;

  // Releases a fixed or moved region of an elastic object permanently. Fails if the region does not exist.
  Result<void> release_region(uint32_t object_id, const std::string& region);
  // Changes the material; the behaviour must stay the same. Elastic objects keep their cells, and their
  // substeps are limited to the unused part of elastic_node_substeps or an equal share of it, whichever is
  // larger. Rigid objects that are fragile or have pieces need a break_impulse_n_s of 1e-6 to 1e6.
  Result<void> set_material(uint32_t object_id, const Material& material);
  const Material* material(uint32_t object_id) const;

  // Sets the pieces of a rigid object, cut from the mesh and fill it was added with; without pieces it does
  // not break. A fragile object breaks if the impulses of impacts on it, summed over 1/60 s, plus one
  // millisecond of sustained loads reach material().break_impulse_n_s (impact_record.h). Fragments break
  // again, down to single pieces.
  Result<void> set_pieces(uint32_t object_id, std::shared_ptr<const BreakablePieces> pieces);
  // Breaks the object at a material point (object frame at rest) like an impact of kForcedBreakFactor times
  // its threshold, without adding momentum. Fails with a reason if no bond breaks there.
  Result<void> break_object(uint32_t object_id, const Eigen::Vector3d& rest_point_m);
  // BodyState::body_index of each piece; empty until the object breaks.
  std::span<const uint32_t> piece_bodies(uint32_t object_id) const;
  uint32_t revision(uint32_t object_id) const;  // number of fractures so far

  // Rest state without object_from_asset, which the scene adds. Precondition: the object exists.
  RestBody rest_body(uint32_t object_id) const;
  DriverFrame drivers() const;  // objects by ascending id
  std::vector<BodyState> bodies() const;
  const ElasticBody* elastic_body(uint32_t object_id) const;  // nullptr if the object is not elastic
  BodyEnergy energy() const;
  std::vector<WorldEvent> take_events();
  StepTimes last_times() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Computes the data that depend only on the form of a body, before it is added: in parallel, and once for
// bodies that are added again, as when a scene is reset. Bodies without it compute it when they are added,
// with the same result. Any thread. Nothing is computed for a description that add_rigid or add_elastic
// refuses.
void prepare_body(RigidBodyDescription& description);
void prepare_body(ElasticBodyDescription& description);

// Minimum impulse per tick of a reported contact event, N s. Larger: fewer events.
inline constexpr double kReportedImpulse_n_s = 0.02;

inline constexpr double kForcedBreakFactor = 2.5;

}  // namespace livegs
