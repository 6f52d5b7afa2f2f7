// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <functional>

#include "physics/ablation/ablation.h"
#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/rigid_islands.h"

namespace livegs {
namespace {

// Sag of a contact under the weight that it carries, relative to the bounding radius of the smaller body.
// Smaller: less sag under heavy bodies, more steps.
constexpr double kMaxSag = 5e-4;
// A column of bodies of radius r and height H, with springs at its contacts, buckles under its own weight if
// the sag at its foot exceeds 3.4 r³/H² (Greenhill's column with the rotational stiffness of four springs at
// the corners of a cube). One sweep a step leaves the springs several times softer, hence the smaller number.
constexpr double kMaxColumnSag = 0.4;
// Manifolds times solver steps, or times sub-intervals; eight manifolds or fewer may take an eighth of it,
// 128 steps. Larger: less sag at high mass ratios and low rates, faster thin pairs are resolved, more time.
constexpr int kMaxManifoldSolves = 1024;

constexpr double kFastPairThicknesses = 6.0;  // displacement per substep, relative to both thicknesses

double thickness_m(const RigidShape& shape) {
  return shape.convex ? 2.0 * shape.inner_radius_m : shape.wall_m;
}

double detections_of_pair(const RigidBody& a, const RigidBody& b, double duration_s) {
  if (a.shape.is_ball() || b.shape.is_ball()) return 1.0;
  const double displacement = duration_s * max_approach_m_s(a, b);
  if (!(displacement > kFastPairThicknesses * (thickness_m(a.shape) + thickness_m(b.shape)))) return 1.0;
  const double turn = displacement / std::min(a.shape.bounding_radius_m, b.shape.bounding_radius_m);
  return std::ceil(turn / kMaxTurn_rad);
}

// A contact that carries weight. `below`: nullptr if static.
struct Support {
  const RigidBody *above, *below;
};

std::vector<Support> supports(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2) {
  const double upwards = kSameSideCosine * gravity_m_s2.norm();
  std::vector<Support> found;
  for (const RigidIsland::Contact& contact : island.contacts) {
    const RigidBody* other = contact.manifold->other;
    const double up = -contact.manifold->normal.dot(gravity_m_s2);  // the normal points towards the owner
    if (std::abs(up) <= upwards) continue;
    const RigidBody *above = up > 0.0 ? contact.owner : other, *below = up > 0.0 ? other : contact.owner;
    if (!above || above->asleep) continue;
    found.push_back({above, below && !below->asleep ? below : nullptr});
  }
  return found;
}

// The largest ratio of the sag of a contact to its limit, at solver steps of `step_s`. Each body divides its
// weight, and the weight on it, equally among the contacts below it.
double worst_sag(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2, double step_s) {
  const double gravity = gravity_m_s2.norm();
  if (!(gravity > 0.0)) return 0.0;
  std::vector<Support> carrying = supports(island, gravity_m_s2);
  struct Load {
    const RigidBody* body;
    double mass_kg, height_m, top_m;  // with all that the body carries
    int supports = 0;
  };
  std::vector<Load> loads;
  for (const RigidBody* body : island.bodies) {
    const double height_m = -body->world_from_body.position_m.dot(gravity_m_s2) / gravity;
    loads.push_back({body, body->mass_kg, height_m, height_m + body->shape.bounding_radius_m});
  }
  std::ranges::sort(loads, {}, &Load::body);
  const auto load_of = [&](const RigidBody* body) -> Load& {
    return *std::ranges::lower_bound(loads, body, {}, &Load::body);
  };
  for (const Support& support : carrying) ++load_of(support.above).supports;
  std::ranges::stable_sort(carrying, std::greater(),
                           [&](const Support& support) { return load_of(support.above).height_m; });
  const double compliance = 1.0 / std::pow(contact_rate_rad_s(step_s), 2);  // sag per kg of load, times mass
  double worst = 0.0;
  for (const Support& support : carrying) {
    const Load above = load_of(support.above);
    const double carried_kg = above.mass_kg / above.supports;
    double inverse_mass = 1.0 / support.above->mass_kg, radius_m = support.above->shape.bounding_radius_m;
    if (support.below) {
      Load& below = load_of(support.below);
      below.mass_kg += carried_kg;
      below.top_m = std::max(below.top_m, above.top_m);
      inverse_mass += 1.0 / support.below->mass_kg;
      radius_m = std::min(radius_m, support.below->shape.bounding_radius_m);
    }
    const double sag_m = carried_kg * gravity * compliance * inverse_mass;
    const double column_m = above.top_m - above.height_m + radius_m;
    const double limit_m =
        radius_m * std::min(kMaxSag, kMaxColumnSag * radius_m * radius_m / (column_m * column_m));
    worst = std::max(worst, sag_m / limit_m);
  }
  return worst;
}

}  // namespace

StepPlan plan_steps(const RigidIsland& island, const Eigen::Vector3d& gravity_m_s2, double duration_s,
                    int usual_steps) {
  StepPlan plan{1, usual_steps};
  double detections = 1.0;
  for (const RigidIsland::Contact& contact : island.contacts) {
    const RigidBody* other = contact.manifold->other;
    if (contact.owner->joints || (other && other->joints)) return plan;
    if (!other || other->asleep || contact.owner->asleep) continue;
    detections = std::max(detections, detections_of_pair(*contact.owner, *other, duration_s));
  }
  if (without(Mechanism::DetectionsBySpeed)) detections = 1.0;
  const int manifolds = std::max(1, static_cast<int>(island.contacts.size()));
  const int most = kMaxManifoldSolves / std::max(8, manifolds);
  // Each sub-interval takes the usual steps.
  detections = std::min<double>(detections, kMaxManifoldSolves / 8 / usual_steps);
  plan.detections = std::clamp(kMaxManifoldSolves / manifolds, 1, static_cast<int>(detections));
  if (plan.detections > 1 || most <= usual_steps || without(Mechanism::StepsByLoad)) return plan;
  const double needed = std::ceil(std::sqrt(worst_sag(island, gravity_m_s2, duration_s)));
  plan.steps = static_cast<int>(std::clamp<double>(needed, usual_steps, most));
  return plan;
}

}  // namespace livegs
