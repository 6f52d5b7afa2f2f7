// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>

// Contact between a rigid body and something else: up to four points that share one friction manifold.

namespace livegs {

struct RigidBody;

inline constexpr int kMaxManifoldPoints = 4;

// How two bodies answer an impulse along one direction at one place.
struct ContactRow {
  Eigen::Vector3d direction;
  Eigen::Vector3d lever_a, lever_b;  // arm x direction
  Eigen::Vector3d turn_a, turn_b;    // inverse inertia times lever: the spin of a unit impulse
  double mass_kg = 0;                // impulse over change of speed
};

struct ContactPoint {
  uint64_t feature_id = 0;
  Eigen::Vector3d normal;
  Eigen::Vector3d arm_a_m;     // from the first body's centre of mass, world axes
  Eigen::Vector3d arm_body_m;  // the same in its own axes
  double separation_m = 0;
  bool turns =
      false;  // a point of the first body's mesh; where a ball or the other body touches stays in the substep
  double impact_speed_m_s = 0;     // closing speed at touch, > 0 when closing
  double approach_speed_m_s = 0;   // at the start of the substep, > 0 when closing
  double time_of_impact_s = 0;     // from the start of the substep
  double carried_speed_m_s = 0;    // what presses the two together would give them in the rest of the substep
  double impulse_n_s = 0;          // of this step, >= 0; the next one starts from it
  double resting_impulse_n_s = 0;  // before restitution
  double largest_impulse_n_s = 0;

  // Refreshed when the bodies have moved.
  Eigen::Vector3d arm_b_m;
  ContactRow row;

  Eigen::Vector3d anchor_b_m;  // where it was found on the other, in its axes: see reuse_manifold
};

struct ContactManifold {
  RigidBody* other = nullptr;  // nullptr: a collider, which does not move
  uint64_t other_id = 0;       // RigidBody::body_id, or kColliderBit + index
  double friction = 0;
  double restitution = 0;
  double restitution_speed_m_s = 0;  // impacts slower than this do not bounce
  double push_speed_m_s = 0;         // overlaps part no faster than this

  std::array<ContactPoint, kMaxManifoldPoints> points;
  int point_count = 0;

  bool turns = false;  // all of its points do

  // Friction acts at the centre of pressure, in the plane of the mean normal, and as a twist about it.
  Eigen::Vector3d normal;
  Eigen::Vector3d arm_a_m, arm_body_m;
  Eigen::Vector3d friction_impulse_n_s = Eigen::Vector3d::Zero();
  double twist_impulse = 0;   // N m s
  double twist_radius_m = 0;  // mean distance of the points from the centre

  Eigen::Vector3d arm_b_m;
  ContactRow tangent, bitangent;
  Eigen::Matrix2d tangent_mass;
  Eigen::Vector3d twist_turn_a, twist_turn_b;
  double twist_mass = 0;

  // As it was found, for as long as the two do not move against each other: see reuse_manifold.
  bool lasts = false;
  bool normal_is_others = false;  // fixed in the other's axes, else in the first body's
  Eigen::Vector3d found_normal;   // in those axes
  Eigen::Quaterniond found_turn;  // first from other
  Eigen::Vector3d found_shift_m;
};

inline constexpr uint64_t kColliderBit = uint64_t{1} << 40;

}  // namespace livegs
