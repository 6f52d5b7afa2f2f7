// SPDX-License-Identifier: GPL-3.0-or-later
// Catto 2024, Solver2D (soft step): substeps of warm start, one biased solve, move, one solve without bias.
#include "physics/rigid/contact/contact_solver.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

constexpr double kContactCycles = 0.25;   // contact spring periods per step; larger: overlaps bounce
constexpr double kContactDamping = 10.0;  // damping ratio; smaller: faster overlap correction, more bounce

using Eigen::Vector3d;

inline ContactRow row_of(const RigidBody& a, const RigidBody* b, const Vector3d& direction,
                         const Vector3d& arm_a, const Vector3d& arm_b) {
  ContactRow row;
  row.direction = direction;
  row.lever_a = arm_a.cross(direction);
  row.turn_a.noalias() = a.inverse_inertia * row.lever_a;
  double response = a.inverse_mass + row.lever_a.dot(row.turn_a);
  if (b) {
    row.lever_b = arm_b.cross(direction);
    row.turn_b.noalias() = b->inverse_inertia * row.lever_b;
    response += b->inverse_mass + row.lever_b.dot(row.turn_b);
  }
  row.mass_kg = response > 0.0 ? 1.0 / response : 0.0;
  return row;
}

// Separating speed of a and b along the row.
inline double speed_along(const RigidBody& a, const RigidBody* b, const ContactRow& row) {
  double speed = row.direction.dot(a.velocity_m_s) + row.lever_a.dot(a.angular_velocity_rad_s);
  if (b) speed -= row.direction.dot(b->velocity_m_s) + row.lever_b.dot(b->angular_velocity_rad_s);
  return speed;
}

inline void push(RigidBody& body, double impulse, const Vector3d& direction, const Vector3d& lever,
                 const Vector3d& turn) {
  if (body.asleep) return;
  body.velocity_m_s += (impulse * body.inverse_mass) * direction;
  body.angular_momentum += impulse * lever;
  body.angular_velocity_rad_s += impulse * turn;
}

inline void apply(RigidBody& a, RigidBody* b, const ContactRow& row, double impulse) {
  push(a, impulse, row.direction, row.lever_a, row.turn_a);
  if (b) push(*b, -impulse, row.direction, row.lever_b, row.turn_b);
}

inline void twist(RigidBody& body, double impulse, const Vector3d& axis, const Vector3d& turn) {
  if (body.asleep) return;
  body.angular_momentum += impulse * axis;
  body.angular_velocity_rad_s += impulse * turn;
}

inline void apply_twist(RigidBody& a, ContactManifold& manifold, double impulse) {
  twist(a, impulse, manifold.normal, manifold.twist_turn_a);
  if (manifold.other) twist(*manifold.other, -impulse, manifold.normal, manifold.twist_turn_b);
}

// Deviation of a rotating point from its straight path in `step_s`, along the normal. Without it, the next
// facets of a rolling body would be stopped before they land, and a body pivoting on a corner would rise.
inline double way_off_line_m(const RigidBody& body, const ContactPoint& point, double step_s) {
  if (!point.turns) return 0.0;
  const Vector3d& spin = body.angular_velocity_rad_s;
  return 0.5 * step_s * step_s * point.normal.dot(spin.cross(spin.cross(point.arm_a_m)));
}

}  // namespace

ContactSoftness contact_softness(double step_s) {
  const double omega = 2.0 * std::numbers::pi * kContactCycles / step_s;
  const double a1 = 2.0 * kContactDamping + step_s * omega;
  const double a2 = step_s * omega * a1;
  return {omega / a1, a2 / (1.0 + a2), 1.0 / (1.0 + a2)};
}

void prepare_manifold(RigidBody& a, ContactManifold& manifold) {
  RigidBody* b = manifold.other;
  // Both bodies are pushed at the same point, which conserves angular momentum.
  const Vector3d between =
      b ? Vector3d(a.world_from_body.position_m - b->world_from_body.position_m) : Vector3d::Zero();
  const Eigen::Matrix3d rotation = a.world_from_body.orientation.toRotationMatrix();
  for (int i = 0; i < manifold.point_count; ++i) {
    ContactPoint& point = manifold.points[i];
    if (point.turns) point.arm_a_m = rotation * point.arm_body_m;
    point.arm_b_m = point.arm_a_m + between;
    point.row = row_of(a, b, point.normal, point.arm_a_m, point.arm_b_m);
  }
  if (manifold.turns) manifold.arm_a_m = rotation * manifold.arm_body_m;
  manifold.arm_b_m = manifold.arm_a_m + between;
  const Vector3d tangent = manifold.normal.unitOrthogonal();
  manifold.tangent = row_of(a, b, tangent, manifold.arm_a_m, manifold.arm_b_m);
  manifold.bitangent = row_of(a, b, manifold.normal.cross(tangent), manifold.arm_a_m, manifold.arm_b_m);
  Eigen::Matrix2d k;
  k(0, 0) = manifold.tangent.mass_kg > 0.0 ? 1.0 / manifold.tangent.mass_kg : 0.0;
  k(1, 1) = manifold.bitangent.mass_kg > 0.0 ? 1.0 / manifold.bitangent.mass_kg : 0.0;
  k(0, 1) = k(1, 0) = manifold.tangent.lever_a.dot(manifold.bitangent.turn_a) +
                      (b ? manifold.tangent.lever_b.dot(manifold.bitangent.turn_b) : 0.0);
  manifold.tangent_mass = k.determinant() > 0.0 ? k.inverse().eval() : Eigen::Matrix2d::Zero().eval();
  manifold.twist_turn_a = a.inverse_inertia * manifold.normal;
  double response = manifold.normal.dot(manifold.twist_turn_a);
  if (b) {
    manifold.twist_turn_b = b->inverse_inertia * manifold.normal;
    response += manifold.normal.dot(manifold.twist_turn_b);
  }
  manifold.twist_mass = response > 0.0 ? 1.0 / response : 0.0;
}

void warm_start_manifold(RigidBody& a, ContactManifold& manifold) {
  for (int i = 0; i < manifold.point_count; ++i)
    apply(a, manifold.other, manifold.points[i].row, manifold.points[i].impulse_n_s);
  const double along = manifold.tangent.direction.dot(manifold.friction_impulse_n_s);
  const double across = manifold.bitangent.direction.dot(manifold.friction_impulse_n_s);
  manifold.friction_impulse_n_s = along * manifold.tangent.direction + across * manifold.bitangent.direction;
  apply(a, manifold.other, manifold.tangent, along);
  apply(a, manifold.other, manifold.bitangent, across);
  apply_twist(a, manifold, manifold.twist_impulse);
}

double total_impulse(const ContactManifold& manifold) {
  double total = 0.0;
  for (int i = 0; i < manifold.point_count; ++i) total += manifold.points[i].impulse_n_s;
  return total;
}

void solve_friction(RigidBody& a, ContactManifold& manifold) {
  const double limit = manifold.friction * total_impulse(manifold);

  double spin = manifold.normal.dot(a.angular_velocity_rad_s);
  if (manifold.other) spin -= manifold.normal.dot(manifold.other->angular_velocity_rad_s);
  const double twist_limit = limit * manifold.twist_radius_m;
  const double wanted_twist =
      std::clamp(manifold.twist_impulse - manifold.twist_mass * spin, -twist_limit, twist_limit);
  apply_twist(a, manifold, wanted_twist - manifold.twist_impulse);
  manifold.twist_impulse = wanted_twist;

  const Eigen::Vector2d before(manifold.tangent.direction.dot(manifold.friction_impulse_n_s),
                               manifold.bitangent.direction.dot(manifold.friction_impulse_n_s));
  const Eigen::Vector2d slip(speed_along(a, manifold.other, manifold.tangent),
                             speed_along(a, manifold.other, manifold.bitangent));
  Eigen::Vector2d wanted = before - manifold.tangent_mass * slip;
  const double length = wanted.norm();
  if (length > limit) wanted *= limit / length;
  apply(a, manifold.other, manifold.tangent, wanted.x() - before.x());
  apply(a, manifold.other, manifold.bitangent, wanted.y() - before.y());
  manifold.friction_impulse_n_s =
      wanted.x() * manifold.tangent.direction + wanted.y() * manifold.bitangent.direction;
}

void solve_manifold(RigidBody& a, ContactManifold& manifold, ContactPhase phase, double step_s) {
  solve_friction(a, manifold);
  const ContactSoftness soft = contact_softness(step_s);
  for (int i = 0; i < manifold.point_count; ++i) {
    ContactPoint& point = manifold.points[i];
    double bias = 0.0, mass_scale = 1.0, impulse_scale = 0.0;
    const double separation = point.separation_m + way_off_line_m(a, point, step_s);
    if (separation > 0.0) {
      bias = separation / step_s;  // may close the gap but not overlap
    } else if (phase == ContactPhase::Push) {
      bias = std::max(soft.bias_rate * separation, -manifold.push_speed_m_s);
      mass_scale = soft.mass_scale;
      impulse_scale = soft.impulse_scale;
    }
    const double change =
        -point.row.mass_kg * mass_scale * (speed_along(a, manifold.other, point.row) + bias) -
        impulse_scale * point.impulse_n_s;
    const double impulse = std::max(0.0, point.impulse_n_s + change);
    apply(a, manifold.other, point.row, impulse - point.impulse_n_s);
    point.impulse_n_s = impulse;
    point.largest_impulse_n_s = std::max(point.largest_impulse_n_s, impulse);
  }
}

void update_separations(RigidBody& a, ContactManifold& manifold, double step_s) {
  for (int i = 0; i < manifold.point_count; ++i) {
    ContactPoint& point = manifold.points[i];
    point.separation_m +=
        way_off_line_m(a, point, step_s) + step_s * speed_along(a, manifold.other, point.row);
  }
}

bool apply_restitution(RigidBody& a, ContactManifold& manifold) {
  if (manifold.restitution <= 0.0) return false;
  bool bounced = false;
  for (int i = 0; i < manifold.point_count; ++i) {
    ContactPoint& point = manifold.points[i];
    if (point.impact_speed_m_s < manifold.restitution_speed_m_s || point.largest_impulse_n_s <= 0.0) continue;
    const double leaving = speed_along(a, manifold.other, point.row);
    const double change = -point.row.mass_kg * (leaving - manifold.restitution * point.impact_speed_m_s);
    const double impulse = std::max(0.0, point.impulse_n_s + change);
    apply(a, manifold.other, point.row, impulse - point.impulse_n_s);
    point.impulse_n_s = impulse;
    bounced = true;
  }
  return bounced;
}

}  // namespace livegs
