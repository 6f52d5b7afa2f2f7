// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "core/pose.h"
#include "physics/collision/collision_shape.h"
#include "physics/motion/body_id.h"
#include "physics/motion/free_rotation.h"
#include "physics/rigid/contact/contact_point.h"
#include "physics/rigid/contact/impact_record.h"

namespace livegs {

class JointGroup;
struct RigidSpring;

// One rigid body or ball in motion. World frame unless a name says body; the body's origin is its centre of
// mass. One thread at a time. The velocity solver reads and writes velocity, angular velocity and angular
// momentum together through apply_impulse; everything else reads.
struct RigidBody {
  uint32_t object_id = 0;
  uint32_t body_index = 0;  // within the object: 0 until it breaks; under kMaxBodiesOfObject
  Eigen::Vector3d rest_centre_m = Eigen::Vector3d::Zero();  // the centre of mass at rest, object frame
  RigidShape shape;

  double mass_kg = 0.0;
  Eigen::Matrix3d unit_inertia_body = Eigen::Matrix3d::Identity();  // of 1 kg: by set_unit_inertia
  PrincipalAxes unit_axes;                                          // of it
  double friction = 0.5;
  double restitution = 0.2;

  Pose world_from_body;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  // about the centre of mass, kg m²/s: the state
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  // follows from it: see update_turning

  bool asleep = false;
  // Over the tick: an elastic body bears or pushes it; and one of its company is not ready to sleep.
  bool in_elastic_contact = false, island_awake = false;
  double still_s = 0.0;  // for how long it has been slower than the sleep speed
  uint64_t sleep_group =
      0;              // bodies that fell asleep together wake together: the lowest id of them, plus one
  uint32_t slot = 0;  // its place in the list that is being worked on

  // What resists an impulse now; zero while asleep, so that a sleeper is as good as a wall.
  double inverse_mass = 0.0;
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();

  Eigen::Vector3d substep_velocity_m_s = Eigen::Vector3d::Zero();  // at the start of the substep
  Eigen::Vector3d substep_acceleration_m_s2 = Eigen::Vector3d::Zero();
  bool pushed_by_owner = false;            // in this substep, by a manifold that another body owns
  bool has_body_contact = false;           // in this substep, as owner or not
  std::vector<RigidBody*> near;            // pairs this body owns: ascending id, see rigid_broad_phase.h
  std::vector<ContactManifold> manifolds;  // where this body is the first of the pair
  std::vector<ContactManifold> previous_manifolds;  // of the substep before, for warm starting

  std::vector<RigidSpring*> springs;  // that hands hold it by, in this substep
  JointGroup* joints = nullptr;       // the bodies it hangs together with by joints; nullptr: none

  // Over the tick: from all that touches it, and, for its object's events, without what other bodies of the
  // object gave.
  double contact_impulse_n_s = 0.0;
  double external_contact_impulse_n_s = 0.0;
  Eigen::Vector3d external_contact_moment = Eigen::Vector3d::Zero();  // impulse times point
  double last_tick_contact_impulse_n_s = 0.0;                         // contact_impulse_n_s of the last tick
  bool can_break = false;  // it has pieces: its impacts are counted
  ImpactRecord impacts;
  double tick_energy_j = 0.0;  // of its motion and its weight, at the start of the tick

  // Unique in a world and ascending as its list of bodies; below kColliderBit.
  uint64_t body_id() const { return body_id_of(object_id, body_index); }

  // Where a material point (object frame, at rest) is, from the centre of mass, world axes.
  Eigen::Vector3d arm_of(const Eigen::Vector3d& rest_point_m) const {
    return world_from_body.orientation * (rest_point_m - rest_centre_m);
  }
  Eigen::Matrix3d inverse_inertia_body() const { return (mass_kg * unit_inertia_body).inverse(); }
  Eigen::Vector3d point_velocity(const Eigen::Vector3d& arm_m) const {
    return velocity_m_s + angular_velocity_rad_s.cross(arm_m);
  }
  void wake();
  void set_unit_inertia(const Eigen::Matrix3d& of_one_kg);
  // Refreshes what follows from orientation, angular momentum and sleep.
  void update_turning();
  void set_angular_velocity(const Eigen::Vector3d& velocity_rad_s);
  // An impulse at `arm_m` from the centre of mass.
  void apply_impulse(const Eigen::Vector3d& impulse_n_s, const Eigen::Vector3d& arm_m);
  void apply_angular_impulse(const Eigen::Vector3d& impulse);
  // Moves by the present velocities. Where no contact held it, displacement is the mean of the velocities
  // before and after (exact for a constant acceleration, sliding included); along the normals of contacts
  // that pushed, it is that after. Impulses between two bodies move them by the velocity after, which keeps
  // their angular momentum; so do the springs of hands, which reckon with it.
  void move(double duration_s);
  // How move() would move it now.
  Eigen::Vector3d mean_velocity(double duration_s) const;  // of the centre of mass
  Eigen::Quaterniond orientation_after(double duration_s) const;

  double kinetic_j() const {
    return 0.5 * (mass_kg * velocity_m_s.squaredNorm() + angular_velocity_rad_s.dot(angular_momentum));
  }
};

// Slower than this at three points of the body for kTimeToSleep_s, and touching something: it sleeps. At a
// size of 1 m 0.03 m/s (Jolt's value), with the square root of size below, as speeds under gravity go.
inline constexpr double kSleepSpeed_m_s = 0.03;
inline constexpr double kTimeToSleep_s = 0.5;
double sleep_speed_m_s(const RigidShape& shape);
// The largest speed of the centre of mass, which moves with `velocity_m_s`, and of two points at right angles
// on the bounding sphere.
double three_point_speed_m_s(const RigidBody& body, const Eigen::Vector3d& velocity_m_s);

}  // namespace livegs
