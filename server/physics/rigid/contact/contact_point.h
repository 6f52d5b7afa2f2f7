// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>

// Contact manifold between a rigid body and another body or collider: up to four points.

namespace livegs {

struct RigidBody;

// Maximum number of points per manifold. Four span any flat contact.
inline constexpr int kMaxManifoldPoints = 4;

struct ContactPoint {
  uint64_t feature_id = 0;
  Eigen::Vector3d normal;
  Eigen::Vector3d arm_a_m;     // from the first body's centre of mass, world axes
  Eigen::Vector3d arm_body_m;  // the same in body axes
  double separation_m = 0;
  // Whether the point is fixed to the first body's mesh. Points of balls or of the other body stay in place
  // during the substep.
  bool turns = false;
  // Speeds of an impact: closing speed, closing speed at touch, and speed at which it leaves, < 0 if it has
  // yet to arrive; nullopt: not one.
  double closing_m_s = 0, touch_m_s = 0;
  std::optional<double> leaving_m_s;
  double friction = 0;     // coefficient of the surfaces that touch here
  double impulse_n_s = 0;  // of this step, >= 0; warm start of the next one
  Eigen::Vector3d friction_impulse_n_s = Eigen::Vector3d::Zero();  // likewise, of this point alone

  Eigen::Vector3d anchor_b_m;  // position on the other body at detection, in its axes (reuse_manifold)
};

// Properties of all contacts of a pair.
struct ContactPair {
  RigidBody* other = nullptr;    // nullptr: a collider, which is static
  uint64_t other_id = 0;         // RigidBody::body_id, or of a collider, above those
  double collider_friction = 0;  // without another body
  double restitution = 0;
  double restitution_speed_m_s = 0;  // slower impacts do not bounce
  double push_speed_m_s = 0;         // maximum speed of overlap correction
  double size_m = 0;                 // bounding radius of the smaller body
  bool lasts = false;                // two convex bodies: contacts are reusable while the pair does not move
};

struct ContactManifold : ContactPair {
  std::array<ContactPoint, kMaxManifoldPoints> points;
  int point_count = 0;

  bool turns = false;  // whether all points do

  // Friction of all points: a force at their mean, in the plane of the mean normal, and a twist about it
  // (contact_friction.h).
  Eigen::Vector3d normal;
  Eigen::Vector3d arm_a_m, arm_body_m;
  Eigen::Vector3d friction_impulse_n_s = Eigen::Vector3d::Zero();
  double twist_impulse = 0;  // N m s

  Eigen::Vector3d arm_b_m;
  // State at detection, valid while the bodies do not move relative to each other (reuse_manifold).
  bool normal_is_others = false;  // normal fixed in the other body's axes, else in the first body's
  Eigen::Vector3d found_normal;   // in those axes
  Eigen::Quaterniond found_turn;  // first body from other body
  Eigen::Vector3d found_shift_m;

  std::span<ContactPoint> used() { return {points.data(), static_cast<size_t>(point_count)}; }
  std::span<const ContactPoint> used() const { return {points.data(), static_cast<size_t>(point_count)}; }
};

}  // namespace livegs
