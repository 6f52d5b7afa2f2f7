// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/rigid/rigid_body.h"

namespace livegs {
namespace {

constexpr double kContactDamping = 10.0;  // damping ratio; smaller: faster overlap correction, more bounce

// Steps of acceleration that an impact is faster than. Smaller: pressed bodies count as struck.
constexpr double kImpactSteps = 8.0;

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

// As in contact_lanes.cpp.
inline double way_off_line_m(const RigidBody& body, const ContactPoint& point, double step_s) {
  if (!point.turns) return 0.0;
  const Vector3d& spin = body.angular_velocity_rad_s;
  return 0.5 * step_s * step_s * point.normal.dot(spin.cross(spin.cross(point.arm_a_m)));
}

}  // namespace

double closing_acceleration_m_s2(const RigidBody& a, const ContactManifold& manifold,
                                 const ContactPoint& point) {
  double acceleration = a.asleep ? 0.0 : -point.normal.dot(a.substep_acceleration_m_s2);
  if (manifold.other && !manifold.other->asleep)
    acceleration += point.normal.dot(manifold.other->substep_acceleration_m_s2);
  return acceleration;
}

double impact_speed_m_s(const ContactManifold& manifold, double acceleration_m_s2, double step_s) {
  return std::max(manifold.restitution_speed_m_s, kImpactSteps * step_s * acceleration_m_s2);
}

// A quarter of a spring period per step; larger: overlaps bounce.
double contact_rate_rad_s(double step_s) { return 0.5 * std::numbers::pi / step_s; }

ContactSoftness contact_softness(double step_s) {
  const double omega = contact_rate_rad_s(step_s);
  const double a1 = 2.0 * kContactDamping + step_s * omega;
  const double a2 = step_s * omega * a1;
  return {omega / a1, a2 / (1.0 + a2), 1.0 / (1.0 + a2)};
}

ManifoldRows prepare_rows(const RigidBody& a, ContactManifold& manifold) {
  ManifoldRows rows;
  const RigidBody* b = manifold.other;
  const Vector3d between =
      b ? Vector3d(a.world_from_body.position_m - b->world_from_body.position_m) : Vector3d::Zero();
  const Eigen::Matrix3d rotation = a.world_from_body.orientation.toRotationMatrix();
  for (int i = 0; i < manifold.point_count; ++i) {
    ContactPoint& point = manifold.points[i];
    if (point.turns) point.arm_a_m = rotation * point.arm_body_m;
    rows.points[i] = row_of(a, b, point.normal, point.arm_a_m, point.arm_a_m + between);
  }
  if (manifold.turns) manifold.arm_a_m = rotation * manifold.arm_body_m;
  manifold.arm_b_m = manifold.arm_a_m + between;
  const Vector3d tangent = manifold.normal.unitOrthogonal();
  rows.tangent = row_of(a, b, tangent, manifold.arm_a_m, manifold.arm_b_m);
  rows.bitangent = row_of(a, b, manifold.normal.cross(tangent), manifold.arm_a_m, manifold.arm_b_m);
  rows.twist_turn_a = a.inverse_inertia * manifold.normal;
  rows.twist_turn_b = b ? Vector3d(b->inverse_inertia * manifold.normal) : Vector3d::Zero();
  const ContactRow &x = rows.tangent, &y = rows.bitangent;
  const auto both = [&](const Vector3d& on_a, const Vector3d& turn_a, const Vector3d& on_b,
                        const Vector3d& turn_b) { return on_a.dot(turn_a) + (b ? on_b.dot(turn_b) : 0.0); };
  const auto inverse = [](double mass_kg) { return mass_kg > 0.0 ? 1.0 / mass_kg : 0.0; };
  rows.friction.set_response({inverse(x.mass_kg), both(x.lever_a, y.turn_a, x.lever_b, y.turn_b),
                              both(x.lever_a, rows.twist_turn_a, x.lever_b, rows.twist_turn_b),
                              inverse(y.mass_kg),
                              both(y.lever_a, rows.twist_turn_a, y.lever_b, rows.twist_turn_b),
                              both(manifold.normal, rows.twist_turn_a, manifold.normal, rows.twist_turn_b)});
  for (int i = 0; i < manifold.point_count; ++i) {
    const ContactPoint& point = manifold.points[i];
    const Vector3d arm_m = point.arm_a_m - manifold.arm_a_m;
    rows.friction.points[i] = {x.direction.dot(arm_m), y.direction.dot(arm_m), point.friction,
                               x.direction.dot(point.friction_impulse_n_s),
                               y.direction.dot(point.friction_impulse_n_s)};
  }
  rows.friction.impulse = {x.direction.dot(manifold.friction_impulse_n_s),
                           y.direction.dot(manifold.friction_impulse_n_s), manifold.twist_impulse};
  return rows;
}

double total_impulse(const ContactManifold& manifold) {
  double total = 0.0;
  for (const ContactPoint& point : manifold.used()) total += point.impulse_n_s;
  return total;
}

void scale_impulses(ContactManifold& manifold, double factor) {
  for (ContactPoint& point : manifold.used()) {
    point.impulse_n_s *= factor;
    point.friction_impulse_n_s *= factor;
  }
  manifold.friction_impulse_n_s *= factor;
  manifold.twist_impulse *= factor;
}

void solve_friction(RigidBody& a, ContactManifold& manifold, ManifoldRows& rows) {
  double turning = manifold.normal.dot(a.angular_velocity_rad_s);
  if (manifold.other) turning -= manifold.normal.dot(manifold.other->angular_velocity_rad_s);
  std::array<double, kMaxManifoldPoints> pressed_n_s;
  for (int i = 0; i < manifold.point_count; ++i) pressed_n_s[i] = manifold.points[i].impulse_n_s;
  const InPlane<double> change =
      rows.friction.solve(manifold.point_count, pressed_n_s,
                          {speed_along(a, manifold.other, rows.tangent),
                           speed_along(a, manifold.other, rows.bitangent), turning});
  apply(a, manifold.other, rows.tangent, change.x);
  apply(a, manifold.other, rows.bitangent, change.y);
  twist(a, change.turn, manifold.normal, rows.twist_turn_a);
  if (manifold.other) twist(*manifold.other, -change.turn, manifold.normal, rows.twist_turn_b);
}

void store_friction(ContactManifold& manifold, const ManifoldRows& rows) {
  const Vector3d &x = rows.tangent.direction, &y = rows.bitangent.direction;
  for (int i = 0; i < manifold.point_count; ++i) {
    const auto& solved = rows.friction.points[i];
    manifold.points[i].friction_impulse_n_s = solved.x_n_s * x + solved.y_n_s * y;
  }
  manifold.friction_impulse_n_s = rows.friction.impulse.x * x + rows.friction.impulse.y * y;
  manifold.twist_impulse = rows.friction.impulse.turn;
}

double begin_impact(const RigidBody& a, ContactManifold& manifold, double step_s, double passed_on_m_s) {
  double fastest_m_s = 0.0;
  const RigidBody* b = manifold.other;
  const Vector3d between =
      b ? Vector3d(a.world_from_body.position_m - b->world_from_body.position_m) : Vector3d::Zero();
  for (ContactPoint& point : manifold.used()) {
    point.leaving_m_s.reset();
    Vector3d velocity_m_s = a.point_velocity(point.arm_a_m);
    if (b) velocity_m_s -= b->point_velocity(point.arm_a_m + between);
    const double closing = -point.normal.dot(velocity_m_s);
    if (!(closing > 0.0)) continue;
    const double faster = closing_acceleration_m_s2(a, manifold, point);
    const double limit_m_s = impact_speed_m_s(manifold, faster, step_s);
    if (closing < (passed_on_m_s > 0.0 ? std::min(passed_on_m_s, limit_m_s) : limit_m_s)) continue;
    const double separation = point.separation_m + way_off_line_m(a, point, step_s);
    if (separation > step_s * (closing + step_s * faster)) continue;
    // Speeds at the surface, where restitution acts, and back at this distance from it. A slower bounce first
    // closes the distance.
    const double gap = std::max(0.0, point.separation_m), twice_work = 2.0 * faster * gap;
    point.touch_m_s = std::sqrt(std::max(0.0, closing * closing + twice_work));
    const double bounced = manifold.restitution * point.touch_m_s;
    const double arriving = std::min(gap / step_s, closing);
    if (bounced * bounced >= twice_work && bounced > 0.0) {
      point.leaving_m_s = std::sqrt(bounced * bounced - twice_work);
    } else {
      point.leaving_m_s = arriving >= limit_m_s ? -arriving : 0.0;
    }
    point.closing_m_s = closing;
    fastest_m_s = std::max(fastest_m_s, closing);
  }
  return fastest_m_s;
}

double solve_impact(RigidBody& a, ContactManifold& manifold, const ManifoldRows& rows) {
  double largest_m_s = 0.0;
  for (int i = 0; i < manifold.point_count; ++i) {
    ContactPoint& point = manifold.points[i];
    if (!point.leaving_m_s) continue;
    const double short_m_s = *point.leaving_m_s - speed_along(a, manifold.other, rows.points[i]);
    const double impulse = std::max(0.0, point.impulse_n_s + rows.points[i].mass_kg * short_m_s);
    const double change = impulse - point.impulse_n_s;
    apply(a, manifold.other, rows.points[i], change);
    point.impulse_n_s = impulse;
    if (rows.points[i].mass_kg > 0.0)
      largest_m_s = std::max(largest_m_s, std::abs(change) / rows.points[i].mass_kg);
  }
  return largest_m_s;
}

}  // namespace livegs
