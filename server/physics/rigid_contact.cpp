// SPDX-License-Identifier: GPL-3.0-or-later
// Catto 2024, Solver2D (soft step): substeps of warm start, one biased solve, move, one solve without bias.
#include "physics/rigid_contact.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/rigid_body.h"

namespace livegs {
namespace {

constexpr double kContactCycles = 0.25;   // of the contact spring in a step; more and overlaps bounce
constexpr double kContactDamping = 10.0;  // ratio; lower parts overlaps faster and bounces

Eigen::Vector3d relative_velocity(const RigidBody& a, const RigidBody* b, const Eigen::Vector3d& arm_a,
                                  const Eigen::Vector3d& arm_b) {
  const Eigen::Vector3d velocity = a.point_velocity(arm_a);
  return b ? Eigen::Vector3d(velocity - b->point_velocity(arm_b)) : velocity;
}

void apply(RigidBody& a, RigidBody* b, const Eigen::Vector3d& impulse, const Eigen::Vector3d& arm_a,
           const Eigen::Vector3d& arm_b) {
  a.apply_impulse(impulse, arm_a);
  if (b) b->apply_impulse(-impulse, arm_b);
}

// u^T K v of the velocity response K at an arm: how much v-direction impulse speeds up the u direction.
double response(const RigidBody& body, const Eigen::Vector3d& arm, const Eigen::Vector3d& u,
                const Eigen::Vector3d& v) {
  return body.inverse_mass * u.dot(v) + arm.cross(u).dot(body.inverse_inertia * arm.cross(v));
}

// How far a turning point strays in `step_s`, along its normal, from the straight line its velocity points along. Without
// it the next facets of a rolling body are stopped before they would land, and a body that pivots on a corner rises.
double way_off_line_m(const RigidBody& body, const ContactPoint& point, double step_s) {
  if (!point.turns) return 0.0;
  const Eigen::Vector3d& spin = body.angular_velocity_rad_s;
  return 0.5 * step_s * step_s * point.normal.dot(spin.cross(spin.cross(point.arm_a_m)));
}

double pair_response(const RigidBody& a, const RigidBody* b, const Eigen::Vector3d& arm_a,
                     const Eigen::Vector3d& arm_b, const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
  return response(a, arm_a, u, v) + (b ? response(*b, arm_b, u, v) : 0.0);
}

}  // namespace

ContactSoftness contact_softness(double step_s) {
  const double omega = 2.0 * std::numbers::pi * kContactCycles / step_s;
  const double a1 = 2.0 * kContactDamping + step_s * omega;
  const double a2 = step_s * omega * a1;
  return {omega / a1, a2 / (1.0 + a2), 1.0 / (1.0 + a2)};
}

void prepare_patch(RigidBody& a, ContactPatch& patch) {
  RigidBody* b = patch.other;
  // Both bodies are pushed at the same place, so that angular momentum is kept.
  const Eigen::Vector3d between =
      b ? Eigen::Vector3d(a.world_from_body.position_m - b->world_from_body.position_m) : Eigen::Vector3d::Zero();
  for (int i = 0; i < patch.point_count; ++i) {
    ContactPoint& point = patch.points[i];
    if (point.turns) point.arm_a_m = a.world_from_body.orientation * point.arm_body_m;
    point.arm_b_m = point.arm_a_m + between;
    const double k = pair_response(a, b, point.arm_a_m, point.arm_b_m, point.normal, point.normal);
    point.mass_kg = k > 0.0 ? 1.0 / k : 0.0;
  }
  if (patch.turns) patch.arm_a_m = a.world_from_body.orientation * patch.arm_body_m;
  patch.arm_b_m = patch.arm_a_m + between;
  patch.tangent = patch.normal.unitOrthogonal();
  patch.bitangent = patch.normal.cross(patch.tangent);
  Eigen::Matrix2d k;
  k(0, 0) = pair_response(a, b, patch.arm_a_m, patch.arm_b_m, patch.tangent, patch.tangent);
  k(1, 1) = pair_response(a, b, patch.arm_a_m, patch.arm_b_m, patch.bitangent, patch.bitangent);
  k(0, 1) = k(1, 0) = pair_response(a, b, patch.arm_a_m, patch.arm_b_m, patch.tangent, patch.bitangent);
  patch.tangent_mass = k.determinant() > 0.0 ? k.inverse().eval() : Eigen::Matrix2d::Zero().eval();
  double twist = patch.normal.dot(a.inverse_inertia * patch.normal);
  if (b) twist += patch.normal.dot(b->inverse_inertia * patch.normal);
  patch.twist_mass = twist > 0.0 ? 1.0 / twist : 0.0;
}

void warm_start_patch(RigidBody& a, ContactPatch& patch) {
  for (int i = 0; i < patch.point_count; ++i) {
    const ContactPoint& point = patch.points[i];
    apply(a, patch.other, point.impulse_n_s * point.normal, point.arm_a_m, point.arm_b_m);
  }
  patch.friction_impulse_n_s -= patch.normal.dot(patch.friction_impulse_n_s) * patch.normal;
  apply(a, patch.other, patch.friction_impulse_n_s, patch.arm_a_m, patch.arm_b_m);
  a.apply_angular_impulse(patch.twist_impulse * patch.normal);
  if (patch.other) patch.other->apply_angular_impulse(-patch.twist_impulse * patch.normal);
}

double total_impulse(const ContactPatch& patch) {
  double total = 0.0;
  for (int i = 0; i < patch.point_count; ++i) total += patch.points[i].impulse_n_s;
  return total;
}

void rub_patch(RigidBody& a, ContactPatch& patch) {
  const double limit = patch.friction * total_impulse(patch);

  Eigen::Vector3d spin = a.angular_velocity_rad_s;
  if (patch.other) spin -= patch.other->angular_velocity_rad_s;
  const double twist_limit = limit * patch.twist_radius_m;
  const double twist = std::clamp(patch.twist_impulse - patch.twist_mass * patch.normal.dot(spin), -twist_limit,
                                  twist_limit);
  const Eigen::Vector3d turn = (twist - patch.twist_impulse) * patch.normal;
  a.apply_angular_impulse(turn);
  if (patch.other) patch.other->apply_angular_impulse(-turn);
  patch.twist_impulse = twist;

  const Eigen::Vector3d slip = relative_velocity(a, patch.other, patch.arm_a_m, patch.arm_b_m);
  const Eigen::Vector2d stop =
      -(patch.tangent_mass * Eigen::Vector2d(patch.tangent.dot(slip), patch.bitangent.dot(slip)));
  Eigen::Vector3d wanted = patch.friction_impulse_n_s + stop.x() * patch.tangent + stop.y() * patch.bitangent;
  const double length = wanted.norm();
  if (length > limit) wanted *= limit / length;
  apply(a, patch.other, wanted - patch.friction_impulse_n_s, patch.arm_a_m, patch.arm_b_m);
  patch.friction_impulse_n_s = wanted;
}

void solve_patch(RigidBody& a, ContactPatch& patch, ContactPhase phase, double step_s) {
  rub_patch(a, patch);
  const ContactSoftness soft = contact_softness(step_s);
  for (int i = 0; i < patch.point_count; ++i) {
    ContactPoint& point = patch.points[i];
    double bias = 0.0, mass_scale = 1.0, impulse_scale = 0.0;
    const double separation = point.separation_m + way_off_line_m(a, point, step_s);
    if (separation > 0.0) {
      bias = separation / step_s;  // may close the gap, no more
    } else if (phase == ContactPhase::Push) {
      bias = std::max(soft.bias_rate * separation, -patch.push_speed_m_s);
      mass_scale = soft.mass_scale;
      impulse_scale = soft.impulse_scale;
    }
    const double closing =
        point.normal.dot(relative_velocity(a, patch.other, point.arm_a_m, point.arm_b_m));
    const double change = -point.mass_kg * mass_scale * (closing + bias) - impulse_scale * point.impulse_n_s;
    const double impulse = std::max(0.0, point.impulse_n_s + change);
    apply(a, patch.other, (impulse - point.impulse_n_s) * point.normal, point.arm_a_m, point.arm_b_m);
    point.impulse_n_s = impulse;
    point.largest_impulse_n_s = std::max(point.largest_impulse_n_s, impulse);
  }
}

void follow_patch(RigidBody& a, ContactPatch& patch, double step_s) {
  for (int i = 0; i < patch.point_count; ++i) {
    ContactPoint& point = patch.points[i];
    point.separation_m +=
        way_off_line_m(a, point, step_s) + step_s * point.normal.dot(relative_velocity(a, patch.other, point.arm_a_m, point.arm_b_m));
  }
}

bool restitute_patch(RigidBody& a, ContactPatch& patch) {
  if (patch.restitution <= 0.0) return false;
  bool bounced = false;
  for (int i = 0; i < patch.point_count; ++i) {
    ContactPoint& point = patch.points[i];
    if (point.impact_speed_m_s < patch.restitution_speed_m_s || point.largest_impulse_n_s <= 0.0) continue;
    const double leaving = point.normal.dot(relative_velocity(a, patch.other, point.arm_a_m, point.arm_b_m));
    const double change = -point.mass_kg * (leaving - patch.restitution * point.impact_speed_m_s);
    const double impulse = std::max(0.0, point.impulse_n_s + change);
    apply(a, patch.other, (impulse - point.impulse_n_s) * point.normal, point.arm_a_m, point.arm_b_m);
    point.impulse_n_s = impulse;
    bounced = true;
  }
  return bounced;
}

}  // namespace livegs
