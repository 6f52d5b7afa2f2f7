// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/find_contacts.h"

namespace livegs {
namespace {

using Chosen = std::vector<const ContactCandidate*>;

// Weight of a candidate: 1 down to the depth `deep_m`, less for shallow ones, so that touching edges win over
// distant faces.
double nearness(const ContactCandidate& candidate, double deep_m, double equal_depth_m) {
  return 1.0 / (1.0 + std::max(0.0, candidate.separation_m - deep_m) / equal_depth_m);
}

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

  const auto weight = [&](const ContactCandidate& candidate) {
    return nearness(candidate, deep_m, equal_depth_m);
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
  // Twice the signed area of a triangle with a candidate; nearly collinear points count as collinear.
  const auto area = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const ContactCandidate& c) {
    const double size = normal.dot((b - a).cross(c.point_m - a));
    return std::abs(size) > 1e-3 * (b - a).squaredNorm() ? size : 0.0;
  };
  const Eigen::Vector3d second = chosen[1]->point_m;
  choose([&](const ContactCandidate& c) { return weight(c) * std::abs(area(first, second, c)); });
  if (chosen.size() < 3) return chosen;
  const Eigen::Vector3d third = chosen[2]->point_m;
  const double turn = area(first, second, *chosen[2]) > 0.0 ? -1.0 : 1.0;
  choose([&](const ContactCandidate& c) {
    const double beyond = std::max(
        {turn * area(first, second, c), turn * area(second, third, c), turn * area(third, first, c)});
    return weight(c) * std::max(0.0, beyond);
  });
  return chosen;
}

// Three candidates, and the plane of their separations over the contact plane.
struct Facet {
  std::array<const ContactCandidate*, 3> corners;
  Eigen::Vector3d normal;  // of the contact plane

  // Shares of the corners in a point of their plane, negative outside; not finite if the corners are
  // collinear.
  Eigen::Vector3d shares(const Eigen::Vector3d& at_m) const {
    const Eigen::Vector3d &a = corners[0]->point_m, &b = corners[1]->point_m, &c = corners[2]->point_m;
    const auto area = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& q, const Eigen::Vector3d& r) {
      return normal.dot((q - p).cross(r - p));
    };
    return Eigen::Vector3d(area(at_m, b, c), area(a, at_m, c), area(a, b, at_m)) / area(a, b, c);
  }
  bool contains(const Eigen::Vector3d& at_m) const { return shares(at_m).minCoeff() >= 0.0; }
  double height_m(const ContactCandidate& candidate) const {
    return candidate.separation_m -
           shares(candidate.point_m)
               .dot(Eigen::Vector3d(corners[0]->separation_m, corners[1]->separation_m,
                                    corners[2]->separation_m));
  }
};

// Facet below `centre_m` with `first` as a corner; nullopt if all candidates are on one side of the centre.
std::optional<Facet> facet_around(const Chosen& group, const ContactCandidate* first,
                                  const Eigen::Vector3d& centre_m) {
  const Eigen::Vector3d normal = first->normal;
  const Eigen::Vector3d from = first->point_m - centre_m;
  const ContactCandidate *left = nullptr, *right = nullptr;
  double left_cosine = 1.0, right_cosine = 1.0;
  const Eigen::Vector3d ahead = (from - normal * normal.dot(from)).normalized();
  for (const ContactCandidate* candidate : group) {
    Eigen::Vector3d to = candidate->point_m - centre_m;
    to -= normal * normal.dot(to);
    const double sine = normal.dot(ahead.cross(to)), cosine = ahead.dot(to) / to.norm();
    if (sine > 0.0 && cosine < left_cosine) left = candidate, left_cosine = cosine;
    if (sine < 0.0 && cosine < right_cosine) right = candidate, right_cosine = cosine;
  }
  if (!left || !right) return std::nullopt;
  const Facet facet{{first, left, right}, normal};
  return facet.contains(centre_m) ? std::optional(facet) : std::nullopt;
}

// Mean of the candidates of `group` (sorted by depth), weighted by their nearness.
Eigen::Vector3d near_mean_m(const Chosen& group, double equal_depth_m) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double weight = 0.0;
  for (const ContactCandidate* candidate : group) {
    const double share = nearness(*candidate, group.front()->separation_m, equal_depth_m);
    mean += share * candidate->point_m;
    weight += share;
  }
  return mean / weight;
}

// The facet of the lower convex hull, of separations over the contact plane, below `centre_m`: the body would
// rest on it if that is its centre of mass. Found by steps of the simplex method. nullopt if the centre is
// not above the candidates.
std::optional<Facet> resting_facet(const Chosen& group, const Eigen::Vector3d& centre_m, double tolerance_m) {
  std::optional<Facet> facet = facet_around(group, group.front(), centre_m);
  bool lowest = !facet;
  for (size_t step = 0; step < group.size() && !lowest; ++step) {
    const auto height_m = [&](const ContactCandidate* candidate) { return facet->height_m(*candidate); };
    const ContactCandidate* below = *std::ranges::min_element(group, {}, height_m);
    lowest = true;
    if (!(height_m(below) < -tolerance_m)) break;
    // It replaces the corner without which the facet is still below the centre.
    for (size_t i = 0; i < 3 && lowest; ++i) {
      Facet next = *facet;
      next.corners[i] = below;
      if (!next.contains(centre_m)) continue;
      facet = next;
      lowest = false;
    }
  }
  return facet;
}

// Whether the centre is above the area that the points span.
bool supports(const Chosen& points, const Eigen::Vector3d& normal, const Eigen::Vector3d& centre_m) {
  for (size_t a = 0; a < points.size(); ++a) {
    for (size_t b = a + 1; b < points.size(); ++b) {
      for (size_t c = b + 1; c < points.size(); ++c) {
        if (Facet{{points[a], points[b], points[c]}, normal}.contains(centre_m)) return true;
      }
    }
  }
  return false;
}

// Up to four points of `group` (sorted by depth). Widely spread points hold a flat face; under a curved one,
// points between them touch first. So the face on which the body would rest, within a tolerance, comes first,
// with the deepest point, about which the body turns now. Otherwise it would sink in, and its correction
// would feed rocking.
Chosen choose_points(const Chosen& group, Eigen::Vector3d centre_m, double size_m) {
  if (group.size() <= kMaxManifoldPoints) return group;
  const double equal_depth_m = 0.2 * kContactMargin * size_m, tolerance_m = 0.02 * equal_depth_m;
  const Chosen spread = spread_points(group, equal_depth_m);
  std::optional<Facet> facet = resting_facet(group, centre_m, tolerance_m);
  if (!facet) {  // the body tips over, or others hold it too
    centre_m = near_mean_m(group, equal_depth_m);
    facet = resting_facet(group, centre_m, tolerance_m);
  }
  if (!facet) return spread;
  Chosen face;
  for (const ContactCandidate* candidate : group) {
    if (facet->height_m(*candidate) <= tolerance_m) face.push_back(candidate);
  }
  Chosen chosen;
  if (std::ranges::find(face, group.front()) == face.end()) chosen.push_back(group.front());
  const auto add = [&](const auto& points) {
    for (const ContactCandidate* point : points) {
      if (chosen.size() < kMaxManifoldPoints && std::ranges::find(chosen, point) == chosen.end())
        chosen.push_back(point);
    }
  };
  const Chosen spread_face = spread_points(face, equal_depth_m);
  if (!supports(spread_face, facet->normal, centre_m)) add(facet->corners);
  add(spread_face);
  add(spread);
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
    Chosen chosen = choose_points(group, body.world_from_body.position_m, pair.size_m);
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
