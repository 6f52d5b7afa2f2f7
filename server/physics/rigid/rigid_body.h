// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/pose.h"
#include "physics/collision/collision_shape.h"
#include "physics/motion/body_id.h"
#include "physics/motion/free_rotation.h"
#include "physics/rigid/contact/contact_point.h"
#include "physics/rigid/contact/impact_record.h"
#include "physics/surface_friction.h"

namespace livegs {

class JointGroup;
struct RigidSpring;

// World frame, at one time. Moments are about the centre of mass.
struct RigidMotion {
  Eigen::Vector3d velocity_m_s, angular_momentum, angular_velocity_rad_s, position_m;

  double kinetic_j(double mass_kg) const {
    return 0.5 * (mass_kg * velocity_m_s.squaredNorm() + angular_velocity_rad_s.dot(angular_momentum));
  }
};

// A rigid body or ball. World frame unless a name says body; the body's origin is its centre of mass. Used by
// one thread at a time. The velocity solver changes velocity, angular velocity and angular momentum together
// through apply_impulse; other code only reads them.
struct RigidBody {
  uint32_t object_id = 0;
  uint32_t body_index = 0;  // within the object; 0 until it breaks; < kMaxBodiesOfObject
  Eigen::Vector3d rest_centre_m = Eigen::Vector3d::Zero();  // centre of mass at rest, object frame
  RigidShape shape;

  double mass_kg = 0.0;
  Eigen::Matrix3d unit_inertia_body = Eigen::Matrix3d::Identity();  // per kg; set by set_unit_inertia
  PrincipalAxes unit_axes;                                          // of unit_inertia_body
  SurfaceFriction friction;
  double restitution = 0.2;

  Pose world_from_body;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  // State variable; about the centre of mass, kg m²/s.
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // derived, see update_turning

  bool asleep = false;
  // During the tick: in contact with an elastic body; a member of its sleep island cannot sleep yet.
  bool in_elastic_contact = false, island_awake = false;
  double still_s = 0.0;  // time below sleep_speed_m_s (rigid_sleep.h)
  // Group of bodies that fell asleep together and wake together: their lowest id plus one.
  uint64_t sleep_group = 0;
  uint32_t slot = 0;  // index in the list being processed

  // Inverse mass and inertia for the solver; zero while asleep, so that a sleeping body acts as static.
  double inverse_mass = 0.0;
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();

  Eigen::Vector3d substep_velocity_m_s = Eigen::Vector3d::Zero();  // at the start of the substep
  Eigen::Vector3d substep_acceleration_m_s2 = Eigen::Vector3d::Zero();
  bool pushed_by_owner = false;   // in this substep, by a manifold of another owner
  bool has_body_contact = false;  // in this substep, as either body of a pair
  // Partners in the pairs that this body owns, ascending id (rigid_broad_phase.h).
  std::vector<RigidBody*> near;
  std::vector<ContactManifold> manifolds;           // of the pairs that this body owns
  std::vector<ContactManifold> previous_manifolds;  // of the previous substep, for warm starting

  std::vector<RigidSpring*> springs;  // in this substep
  JointGroup* joints = nullptr;       // group of jointed bodies; nullptr: none

  // Contact impulses over the tick, from all contacts and, for events, without other bodies of the same
  // object.
  double contact_impulse_n_s = 0.0;
  double external_contact_impulse_n_s = 0.0;
  Eigen::Vector3d external_contact_moment = Eigen::Vector3d::Zero();  // impulse times point
  double last_tick_contact_impulse_n_s = 0.0;                         // of the last tick
  bool can_break = false;  // it has pieces, so impacts are recorded
  ImpactRecord impacts;
  double tick_energy_j = 0.0;  // kinetic and potential energy at the start of the tick

  // Unique in a world and ascending in its list of bodies; below 2^40.
  uint64_t body_id() const { return body_id_of(object_id, body_index); }

  // Arm of a material point (object frame at rest) from the centre of mass, world axes.
  Eigen::Vector3d arm_of(const Eigen::Vector3d& rest_point_m) const {
    return world_from_body.orientation * (rest_point_m - rest_centre_m);
  }
  // At a surface point, as its arm from the centre of mass, world axes.
  double friction_at(const Eigen::Vector3d& arm_m) const {
    if (!friction.boxes) return friction.own;
    return friction.at(rest_centre_m + world_from_body.orientation.conjugate() * arm_m,
                       shape.bounding_radius_m);
  }
  Eigen::Matrix3d inverse_inertia_body() const { return (mass_kg * unit_inertia_body).inverse(); }
  Eigen::Vector3d point_velocity(const Eigen::Vector3d& arm_m) const {
    return velocity_m_s + angular_velocity_rad_s.cross(arm_m);
  }
  void wake();
  void stop();
  // Stops the body and puts it to sleep together with the other bodies of `group`.
  void sleep(uint64_t group);
  void set_unit_inertia(const Eigen::Matrix3d& of_one_kg);
  // Updates the values derived from orientation, angular momentum and sleep.
  void update_turning();
  void set_angular_velocity(const Eigen::Vector3d& velocity_rad_s);
  // Applies an impulse at `arm_m` from the centre of mass.
  void apply_impulse(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& arm_m);
  void apply_angular_impulse(const Eigen::Vector3d& impulse);
  // Integrates the pose with the mean of the velocities before and after the substep (exact for constant
  // acceleration, including sliding). Along the normals of pushing contacts, and for impulses between two
  // bodies and of springs, it uses the velocity after, which conserves angular momentum.
  void move(double duration_s);
  // Predictions of move() for the current velocities.
  Eigen::Vector3d mean_velocity(double duration_s) const;  // of the centre of mass
  Eigen::Quaterniond orientation_after(double duration_s) const;

  RigidMotion motion() const {
    return {velocity_m_s, angular_momentum, angular_velocity_rad_s, world_from_body.position_m};
  }
  double kinetic_j() const { return motion().kinetic_j(mass_kg); }
  // Records impulses (world axes) that may break the body: of forces at an arm from the centre of mass, and
  // of joints, of an awake body, at a point.
  void record_force(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& arm_m);
  void record_joint(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& point_m, ImpulseKind kind,
                    double remaining_s);
};

// Rotation of a body in one part of a substep, rad: of the smaller body of a fast pair after a corner is
// stopped, of a link of a joint group. Smaller: more parts.
inline constexpr double kMaxTurn_rad = 0.25;

// Bound of the speed at which points of two bodies approach.
double max_approach_m_s(const RigidBody& a, const RigidBody& b);

// Distance along the unit `direction` to the first front-facing surface of the body: its triangles, or the
// sphere of a ball. nullopt if the ray misses or starts inside a ball.
std::optional<double> ray_cast(const RigidBody& body, const Eigen::Vector3d& origin_m,
                               const Eigen::Vector3d& direction);

}  // namespace livegs
