// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/ccd_substeps.h"

#include <algorithm>
#include <cmath>

namespace livegs {
namespace {

constexpr double kFastPairThicknesses = 6.0;  // displacement per substep, relative to both thicknesses
// rotation of the smaller body per sub-interval after a corner is stopped
constexpr double kMaxTurn_rad = 0.25;
// Maximum number of sub-intervals. Larger: faster thin pairs are resolved, more time.
constexpr int kMaxCcdSubsteps = 32;
constexpr size_t kMaxContactSubsteps = 1024;  // manifolds times sub-intervals

double thickness_m(const RigidShape& shape) {
  return shape.convex ? 2.0 * shape.inner_radius_m : shape.wall_m;
}

int ccd_substeps_of_pair(const RigidBody& a, const RigidBody& b, double duration_s) {
  if (a.shape.is_ball() || b.shape.is_ball()) return 1;
  const double speed = (a.velocity_m_s - b.velocity_m_s).norm() +
                       a.angular_velocity_rad_s.norm() * a.shape.bounding_radius_m +
                       b.angular_velocity_rad_s.norm() * b.shape.bounding_radius_m;
  const double displacement = duration_s * speed;
  if (!(displacement > kFastPairThicknesses * (thickness_m(a.shape) + thickness_m(b.shape)))) return 1;
  const double turn = displacement / std::min(a.shape.bounding_radius_m, b.shape.bounding_radius_m);
  return static_cast<int>(std::ceil(std::min<double>(kMaxCcdSubsteps, turn / kMaxTurn_rad)));
}

}  // namespace

int ccd_substeps(const RigidIsland& island, double duration_s) {
  int substeps = 1;
  for (const RigidIsland::Contact& contact : island.contacts) {
    const RigidBody* other = contact.manifold->other;
    if (contact.owner->joints || (other && other->joints)) return 1;
    if (!other || other->asleep || contact.owner->asleep) continue;
    substeps = std::max(substeps, ccd_substeps_of_pair(*contact.owner, *other, duration_s));
  }
  return std::max(1, std::min(substeps, static_cast<int>(kMaxContactSubsteps /
                                                         std::max<size_t>(1, island.contacts.size()))));
}

}  // namespace livegs
