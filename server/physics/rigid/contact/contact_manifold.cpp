// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/find_contacts.h"

namespace livegs {
namespace {

using Chosen = std::vector<const ContactCandidate*>;

// Selects up to four points that span `group` (sorted by depth). Depths that differ by less than
// `equal_depth_m` count as equal, so a resting face is supported by its corners. The lowest feature id wins
// ties. Rounding then has no influence.
Chosen spread_points(Chosen group, double equal_depth_m) {
  if (group.size() <= kMaxManifoldPoints) return group;
  const double deep_m = group[0]->separation_m + equal_depth_m;
  std::ranges::sort(group, {}, &ContactCandidate::feature_id);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double deep_count = 0.0;
  for (const ContactCandidate* candidate : group) {
    if (candidate->separation_m > deep_m) continue;
    mean += candidate->point_m;
    deep_count += 1.0;
  }
  mean /= deep_count;

  // Shallow points have a lower weight, so that touching edges win over distant faces.
  const auto weight = [&](const ContactCandidate& candidate) {
    return 1.0 / (1.0 + std::max(0.0, candidate.separation_m - deep_m) / equal_depth_m);
  };
  Chosen chosen;
  const auto choose = [&](const auto& score) {
    const ContactCandidate* best = nullptr;
    double best_score = 0.0;
    for (const ContactCandidate* candidate : group) {
      const double value = score(*candidate);
      if (value > best_score * (1.0 + 1e-6)) {
        best = candidate;
        best_score = value;
      }
    }
    if (best) chosen.push_back(best);
  };
  choose([&](const ContactCandidate& c) {
    return c.separation_m > deep_m ? 0.0 : (c.point_m - mean).squaredNorm() + 1e-12;
  });
  const Eigen::Vector3d first = chosen[0]->point_m;
  const Eigen::Vector3d normal = chosen[0]->normal;
  choose([&](const ContactCandidate& c) { return weight(c) * (c.point_m - first).squaredNorm(); });
  if (chosen.size() < 2) return chosen;
  const Eigen::Vector3d along = chosen[1]->point_m - first;
  // Twice the signed area of the triangle with the first two points; nearly collinear points count as
  // collinear.
  const auto side = [&](const ContactCandidate& c) {
    const double area = normal.dot(along.cross(c.point_m - first));
    return std::abs(area) > 1e-3 * along.squaredNorm() ? area : 0.0;
  };
  choose([&](const ContactCandidate& c) { return weight(c) * std::max(0.0, side(c)); });
  choose([&](const ContactCandidate& c) { return weight(c) * std::max(0.0, -side(c)); });
  return chosen;
}

// Manifold of the previous substep that this one continues.
const ContactManifold* previous_manifold(const RigidBody& body, const ContactManifold& manifold) {
  const ContactManifold* best = nullptr;
  double best_cosine = kSameDirectionCosine;
  for (const ContactManifold& earlier : body.previous_manifolds) {
    if (earlier.other_id != manifold.other_id) continue;
    const double cosine = earlier.normal.dot(manifold.normal);
    if (cosine > best_cosine) {
      best = &earlier;
      best_cosine = cosine;
    }
  }
  return best;
}

const ContactPoint* previous_point(const RigidBody& body, uint64_t other_id, uint64_t feature_id) {
  for (const ContactManifold& earlier : body.previous_manifolds) {
    if (earlier.other_id != other_id) continue;
    const auto point = std::ranges::find(earlier.used(), feature_id, &ContactPoint::feature_id);
    if (point != earlier.used().end()) return &*point;
  }
  return nullptr;
}

// Friction of the pair at a point of the first body, as its arm from the centre of mass, world axes.
double friction_at(const RigidBody& body, const ContactPair& pair, const Eigen::Vector3d& arm_m) {
  const RigidBody* other = pair.other;
  return mixed_friction(
      body.friction_at(arm_m),
      other ? other->friction_at(body.world_from_body.position_m + arm_m - other->world_from_body.position_m)
            : pair.collider_friction);
}

// Coefficients of the points, and the centre.
void set_friction(const RigidBody& body, ContactManifold& manifold) {
  const bool even = !body.friction.boxes && !(manifold.other && manifold.other->friction.boxes);
  const double shared = even ? friction_at(body, manifold, Eigen::Vector3d::Zero()) : 0.0;
  manifold.arm_a_m.setZero();
  for (ContactPoint& point : manifold.used()) {
    point.friction = even ? shared : friction_at(body, manifold, point.arm_a_m);
    manifold.arm_a_m += point.arm_a_m / manifold.point_count;
  }
  manifold.arm_body_m = body.world_from_body.orientation.conjugate() * manifold.arm_a_m;
}

Pose first_from_other(const RigidBody& body, const RigidBody& other) {
  return body.world_from_body.inverse() * other.world_from_body;
}

void remember(const RigidBody& body, ContactManifold& manifold) {
  const Pose& other = manifold.other->world_from_body;
  manifold.normal_is_others = manifold.turns;  // points of the first body on a face of the other
  const Eigen::Quaterniond& axes =
      manifold.normal_is_others ? other.orientation : body.world_from_body.orientation;
  manifold.found_normal = axes.conjugate() * manifold.normal;
  const Pose relative = first_from_other(body, *manifold.other);
  manifold.found_turn = relative.orientation;
  manifold.found_shift_m = relative.position_m;
  for (ContactPoint& point : manifold.used()) {
    point.anchor_b_m = other.orientation.conjugate() * (body.world_from_body.position_m + point.arm_a_m -
                                                        point.separation_m * point.normal - other.position_m);
  }
}

}  // namespace

bool reuse_manifold(RigidBody& body, const ContactPair& pair) {
  const ContactManifold* earlier = nullptr;
  for (const ContactManifold& manifold : body.previous_manifolds) {
    if (manifold.other_id == pair.other_id && manifold.lasts) earlier = &manifold;
  }
  if (!earlier) return false;
  const RigidBody& other = *earlier->other;
  const Pose relative = first_from_other(body, other);
  const double tolerance = 0.1 * kContactMargin * pair.size_m;  // below it, contacts are reused
  const double turn = 2.0 * (relative.orientation.conjugate() * earlier->found_turn).vec().norm();
  if ((relative.position_m - earlier->found_shift_m).squaredNorm() > tolerance * tolerance ||
      turn * pair.size_m > tolerance) {
    return false;
  }
  ContactManifold manifold = *earlier;
  manifold.restitution = pair.restitution;
  const Pose& place = body.world_from_body;
  manifold.normal = (manifold.normal_is_others ? other.world_from_body.orientation : place.orientation) *
                    manifold.found_normal;
  for (ContactPoint& point : manifold.used()) {
    point.normal = manifold.normal;
    point.arm_a_m = place.orientation * point.arm_body_m;
    const Eigen::Vector3d on_first = place.position_m + point.arm_a_m;
    point.separation_m = manifold.normal.dot(on_first - other.world_from_body * point.anchor_b_m);
  }
  set_friction(body, manifold);
  body.manifolds.push_back(manifold);
  return true;
}

void append_manifolds(RigidBody& body, const ContactPair& pair, std::vector<ContactCandidate>& candidates) {
  // Non-finite candidates cannot be sorted and are removed.
  std::erase_if(candidates, [](const ContactCandidate& candidate) {
    return !std::isfinite(candidate.separation_m) || !candidate.point_m.allFinite() ||
           !candidate.normal.allFinite();
  });
  std::ranges::sort(candidates, {},
                    [](const ContactCandidate& one) { return std::pair(one.separation_m, one.feature_id); });
  const Eigen::Quaterniond body_from_world = body.world_from_body.orientation.conjugate();
  std::vector<char> taken(candidates.size(), 0);
  for (size_t seed = 0; seed < candidates.size(); ++seed) {
    if (taken[seed]) continue;
    Chosen group;
    for (size_t i = seed; i < candidates.size(); ++i) {
      if (taken[i] || candidates[i].normal.dot(candidates[seed].normal) < kSameDirectionCosine) continue;
      taken[i] = 1;
      group.push_back(&candidates[i]);
    }
    Chosen chosen = spread_points(std::move(group), 0.2 * kContactMargin * pair.size_m);
    std::ranges::sort(chosen, {}, &ContactCandidate::feature_id);

    ContactManifold manifold;
    static_cast<ContactPair&>(manifold) = pair;
    manifold.turns = chosen.back()->feature_id < kForeignFeature;
    manifold.normal.setZero();
    for (const ContactCandidate* candidate : chosen) {
      ContactPoint& point = manifold.points[manifold.point_count++];
      point.feature_id = candidate->feature_id;
      point.normal = candidate->normal;
      point.arm_a_m = candidate->point_m - body.world_from_body.position_m;
      point.arm_body_m = body_from_world * point.arm_a_m;
      point.separation_m = candidate->separation_m;
      point.turns = candidate->feature_id < kForeignFeature;
      if (const ContactPoint* earlier = previous_point(body, pair.other_id, candidate->feature_id)) {
        point.impulse_n_s = earlier->impulse_n_s;
        point.friction_impulse_n_s = earlier->friction_impulse_n_s;
      }
      manifold.normal += candidate->normal;
    }
    manifold.normal.normalize();
    set_friction(body, manifold);
    if (pair.lasts) remember(body, manifold);
    if (const ContactManifold* earlier = previous_manifold(body, manifold)) {
      manifold.friction_impulse_n_s = earlier->friction_impulse_n_s;
      manifold.twist_impulse = earlier->twist_impulse;
    }
    body.manifolds.push_back(manifold);
  }
}

}  // namespace livegs
