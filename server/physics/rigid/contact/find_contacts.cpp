// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid/contact/find_contacts.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "physics/ablation/ablation.h"
#include "physics/collision/contact_candidate.h"
#include "physics/rigid/contact/contact_solver.h"
#include "physics/rigid/contact/narrow_phase.h"
#include "physics/rigid/joint/joint_group.h"
#include "physics/rigid/rigid_sleep.h"

namespace livegs {
namespace {

constexpr double kMaxPushSpeed_m_s = 1.0;    // speed of overlap correction; it adds up along a row of bodies
constexpr double kPushSizesPerSecond = 5.0;  // bounding diameters per second
// Two bodies of the same shape coincide if their centres are closer than these fractions of the thinnest side
// and of the wall thickness. Nested bowls do not.
constexpr double kCoincidentDistance = 0.25, kCoincidentWall = 0.75;
// minimum ratio of |sum of depths| to sum of |depths| for a defined direction
constexpr double kMinNetDepth = 0.3;

// Safe fraction of a sampled distance for marching; other shapes have exact distances.
double marching_factor(const Collider& collider) {
  return std::holds_alternative<FieldShape>(collider.shape) ? kFieldMarchFactor : 1.0;
}

double sample_error_m(const Collider& collider) {
  const auto* shape = std::get_if<FieldShape>(&collider.shape);
  return shape ? shape->field->cell_m() : 0.0;
}

double margin_m(const RigidBody& body) { return kContactMargin * body.shape.bounding_radius_m; }

// Contact parameters of a pair. The smaller body determines size_m and the sleep speed. Falls within the
// contact margin do not bounce.
ContactPair pair_of(const RigidBody& body, const RigidBody* other, double restitution, double gravity_m_s2,
                    double duration_s) {
  ContactPair pair;
  pair.restitution = mixed_restitution(body.restitution, restitution);
  const RigidBody& smaller =
      other && other->shape.bounding_radius_m < body.shape.bounding_radius_m ? *other : body;
  pair.size_m = smaller.shape.bounding_radius_m;
  pair.restitution_speed_m_s =
      std::max({2.0 * gravity_m_s2 * duration_s, std::sqrt(2.0 * gravity_m_s2 * kContactMargin * pair.size_m),
                sleep_speed_m_s(smaller.shape)});
  pair.push_speed_m_s = std::min(kMaxPushSpeed_m_s, kPushSizesPerSecond * 2.0 * pair.size_m);
  return pair;
}

// Contact points of the body against a collider. `motion_m` bounds the motion of any point in the substep.
void point_candidates(const RigidBody& body, const Collider& collider, double motion_m,
                      const ContactSearch& search, std::vector<ContactCandidate>& candidates) {
  const Eigen::Matrix3d rotation = body.world_from_body.orientation.toRotationMatrix();
  // The lowest point of a convex body over a plane is a corner.
  const bool plane = std::holds_alternative<PlaneShape>(collider.shape);
  const bool corners = plane && body.shape.convex;
  const std::vector<Eigen::Vector3d>& points =
      corners ? body.shape.convex->vertices_m : body.shape.contact_points_m;
  const auto sample = [&](const Eigen::Vector3d& point) { return sample_surface(collider, point); };
  std::vector<uint32_t> near;
  if (corners) {
    near.resize(points.size());
    std::iota(near.begin(), near.end(), 0u);
  } else {
    const double marching = marching_factor(collider);
    body.shape.contact_tree.near(
        [&](const Eigen::Vector3d& point) {
          const double distance = sample(body.world_from_body.position_m + rotation * point).distance_m;
          return distance > 0.0 ? marching * distance : distance;
        },
        std::max(search.margin_m, motion_m / marching) + 2.0 * sample_error_m(collider), near);
  }
  for (const uint32_t i : near) {
    const Eigen::Vector3d arm = rotation * points[i];
    const Eigen::Vector3d point = body.world_from_body.position_m + arm;
    const Eigen::Vector3d displacement = search.duration_s * body.point_velocity(arm);
    if (plane) {
      const SurfaceSample here = sample(point);
      if (here.distance_m < std::max(search.margin_m, -displacement.dot(here.normal))) {
        candidates.push_back({i, point, here.normal, here.distance_m});
      }
    } else if (const auto found =
                   point_candidate(i, point, sample, displacement, marching_factor(collider), search)) {
      candidates.push_back(*found);
    }
  }
}

// Convex features of a collider, which may press into a face between a body's contact points: points on the
// edges and corners of a box or the ridges of a mesh (radius 0, or half the wall thickness of a thin-wall
// collider), or the centre of a sphere (its radius).
struct ColliderFeature {
  uint64_t id;
  Eigen::Vector3d point_m;  // world frame
  double radius_m;
};

void box_features(const BoxShape& box, const Collider& collider, const Eigen::Vector3d& centre, double reach,
                  double spacing, std::vector<ColliderFeature>& features) {
  const Eigen::Vector3d half = 0.5 * box.size_m;
  const Eigen::Vector3d local = collider.world_from_collider.inverse() * centre;
  for (uint64_t corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d point((corner & 1) ? half.x() : -half.x(), (corner & 2) ? half.y() : -half.y(),
                                (corner & 4) ? half.z() : -half.z());
    if ((point - local).norm() <= reach) {
      features.push_back({kCornerFeature + corner, collider.world_from_collider * point, 0.0});
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (uint64_t side = 0; side < 4; ++side) {
      Eigen::Vector3d point = Eigen::Vector3d::Zero();
      point[u] = (side & 1) ? half[u] : -half[u];
      point[v] = (side & 2) ? half[v] : -half[v];
      const double du = point[u] - local[u], dv = point[v] - local[v];
      const double chord2 = reach * reach - du * du - dv * dv;
      if (chord2 < 0.0) continue;
      const double chord = std::sqrt(chord2);
      const double low = std::max(-half[axis], local[axis] - chord),
                   high = std::min(half[axis], local[axis] + chord);
      for (int64_t k = static_cast<int64_t>(std::ceil(low / spacing)); k * spacing <= high; ++k) {
        point[axis] = static_cast<double>(k) * spacing;
        const uint64_t id = kEdgeFeature + (static_cast<uint64_t>(axis) * 4 + side) * (uint64_t{1} << 26) +
                            static_cast<uint64_t>(k + (int64_t{1} << 25));
        features.push_back({id, collider.world_from_collider * point, 0.0});
      }
    }
  }
}

void ridge_features(const FieldShape& shape, const Collider& collider, const Eigen::Vector3d& centre,
                    double reach, std::vector<ColliderFeature>& features) {
  const RidgePoints& ridges = *shape.ridges;
  const Eigen::Vector3d local = collider.world_from_collider.inverse() * centre;
  std::vector<uint32_t> near;
  reach += shape.half_thickness_m;
  ridges.tree.near([&](const Eigen::Vector3d& point) { return (point - local).norm(); }, reach, near);
  for (const uint32_t i : near) {
    const Eigen::Vector3d& point = ridges.points_m[i];
    if ((point - local).norm() > reach) continue;
    features.push_back({kRidgeFeature + i, collider.world_from_collider * point, shape.half_thickness_m});
  }
}

// Features within `reach_m` of the centre of the body. Points on box edges have fixed positions, so their ids
// are stable; mesh ridges have the spacing of their construction. Planes have no features.
void feature_candidates(const RigidBody& body, const Collider& collider, double reach_m,
                        const ContactSearch& search, std::vector<ContactCandidate>& candidates) {
  const auto& [centre_m, orientation] = body.world_from_body;
  std::vector<ColliderFeature> features;
  if (const auto* box = std::get_if<BoxShape>(&collider.shape)) {
    box_features(*box, collider, centre_m, reach_m, body.shape.contact_spacing_m, features);
  } else if (const auto* sphere = std::get_if<SphereShape>(&collider.shape)) {
    features.push_back({kSphereFeature, collider.world_from_collider.position_m, sphere->radius_m});
  } else if (const auto* field = std::get_if<FieldShape>(&collider.shape); field && field->ridges) {
    ridge_features(*field, collider, centre_m, reach_m, features);
  }
  for (const ColliderFeature& feature : features) {
    const Eigen::Vector3d arm = feature.point_m - centre_m;
    const auto sample = [&](const Eigen::Vector3d& from_centre) {
      const DistanceField::Sample field = body.shape.sample(orientation.conjugate() * from_centre);
      return SurfaceSample{field.distance_m - feature.radius_m, orientation * field.gradient};
    };
    // In the body's frame the feature moves towards it.
    const Eigen::Vector3d displacement = -search.duration_s * body.point_velocity(arm);
    auto found = point_candidate(feature.id, arm, sample, displacement, 1.0, search);
    if (!found) continue;
    found->point_m = feature.point_m - feature.radius_m * found->normal;
    found->normal = -found->normal;
    candidates.push_back(*found);
  }
}

// Contacts of a body that is not a ball.
void collider_candidates(const RigidBody& body, const Collider& collider, const ContactSearch& search,
                         std::vector<ContactCandidate>& candidates) {
  const double reach = body.shape.bounding_radius_m;
  const double motion =
      search.duration_s * (body.velocity_m_s.norm() + body.angular_velocity_rad_s.norm() * reach);
  const double distance = sample_surface(collider, body.world_from_body.position_m).distance_m;
  const double within = reach + motion + search.margin_m;
  if (marching_factor(collider) * distance > within) return;
  const auto* box = std::get_if<BoxShape>(&collider.shape);
  if (body.shape.convex && box && box->polyhedron) {
    const MovingPolyhedron wall{{box->polyhedron.get(),
                                 collider.world_from_collider.orientation.toRotationMatrix(),
                                 collider.world_from_collider.position_m}};
    polyhedron_candidates(moving_polyhedron(body), wall, search, candidates);
    return;
  }
  point_candidates(body, collider, motion, search, candidates);
  feature_candidates(body, collider, within, search, candidates);
}

void find_collider_contacts(RigidBody& body, std::span<const Collider> colliders, double gravity_m_s2,
                            double duration_s, std::vector<ContactCandidate>& candidates) {
  const ContactSearch search{duration_s, margin_m(body)};
  std::vector<ContactCandidate> cores;
  for (size_t index = 0; index < colliders.size(); ++index) {
    const Collider& collider = colliders[index];
    const auto sample = [&](const Eigen::Vector3d& point) { return sample_surface(collider, point); };
    const double marching = marching_factor(collider);
    candidates.clear();
    if (body.shape.is_ball()) {
      ball_candidates(body.world_from_body.position_m, body.shape.sphere_radius_m, sample, body.velocity_m_s,
                      marching, search, candidates);
    } else {
      collider_candidates(body, collider, search, candidates);
    }
    move_to_round_surface(body, PairSide::First, candidates);
    cores.clear();
    core_candidates(body, sample, body.velocity_m_s, marching, search, cores);
    if (without(Mechanism::BodyCores)) cores.clear();
    if (candidates.empty() && cores.empty()) continue;
    ContactPair pair = pair_of(body, nullptr, collider.restitution, gravity_m_s2, duration_s);
    pair.collider_friction = collider.friction;
    pair.other_id = (uint64_t{1} << 40) + index;
    append_manifolds(body, pair, candidates);
    // Separate manifold: among closer points the core would be dropped.
    append_manifolds(body, pair, cores);
  }
}

// A ball against a ball or a mesh. The first of two coincident balls counts as the upper one.
void ball_body_candidates(const RigidBody& ball, const RigidBody& other, const ContactSearch& search,
                          std::vector<ContactCandidate>& candidates) {
  const Eigen::Vector3d& centre = ball.world_from_body.position_m;
  const Eigen::Vector3d velocity =
      ball.velocity_m_s - other.point_velocity(centre - other.world_from_body.position_m);
  ball_candidates(
      centre, ball.shape.sphere_radius_m,
      [&](const Eigen::Vector3d& point) { return sample_body(other, point); }, velocity, 1.0, search,
      candidates);
}

// Coincident meshes of the same shape have all points on each other's surface, and within half their
// thickness the shortest way out leads back into overlap. Separates them along the thinnest side until points
// are inside.
bool separate_coincident(const RigidBody& body, const RigidBody& other,
                         std::vector<ContactCandidate>& candidates) {
  if (without(Mechanism::CoincidentShapes)) return false;
  const Eigen::Vector3d size = body.shape.max_m - body.shape.min_m;
  Eigen::Index thinnest;
  const double width = size.minCoeff(&thinnest);
  const Eigen::Vector3d between = body.world_from_body.position_m - other.world_from_body.position_m;
  if (between.norm() > std::min(kCoincidentDistance * width, kCoincidentWall * body.shape.wall_m) ||
      (size - other.shape.max_m + other.shape.min_m).norm() > 0.01 * width ||
      body.world_from_body.orientation.angularDistance(other.world_from_body.orientation) > 0.25) {
    return false;
  }
  Eigen::Vector3d out = other.world_from_body.orientation * Eigen::Vector3d::Unit(thinnest);
  if (between.dot(out) < 0.0) out = -out;
  candidates.push_back({kBallFeature, body.world_from_body.position_m, out, between.dot(out) - width});
  return true;
}

// Deeply overlapping bodies, such as new fragments, have points on both sides that push in opposite
// directions and lock the pair. Selects one direction, that of the summed depth or away from the other's
// centre, and drops contacts against it while the overlap is deep.
void separate_deep_overlap(const Eigen::Vector3d& between, double size_m,
                           std::vector<ContactCandidate>& candidates) {
  const auto depth_m = [](const ContactCandidate& candidate) {
    return std::max(0.0, -candidate.separation_m);
  };
  const double deep_m = 0.5 * kContactMargin * size_m;  // resting overlaps are a tenth of that
  bool stuck = false;
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  double sum_m = 0.0;
  for (size_t i = 0; i < candidates.size(); ++i) {
    if (depth_m(candidates[i]) <= deep_m) continue;
    out += depth_m(candidates[i]) * candidates[i].normal;
    sum_m += depth_m(candidates[i]);
    for (size_t k = 0; k < i && !stuck; ++k) {
      stuck = depth_m(candidates[k]) > deep_m &&
              candidates[i].normal.dot(candidates[k].normal) < -kSameSideCosine;
    }
  }
  if (!stuck || without(Mechanism::DeepOverlaps)) return;
  if (out.norm() < kMinNetDepth * sum_m) out = between;
  std::erase_if(candidates,
                [&](const ContactCandidate& one) { return depth_m(one) > 0.0 && one.normal.dot(out) < 0.0; });
}

void find_pair_contacts(RigidBody& body, RigidBody& other, double gravity_m_s2, double duration_s,
                        std::vector<ContactCandidate>& candidates) {
  if (joined(body, other)) return;
  const double smaller = std::min(body.shape.bounding_radius_m, other.shape.bounding_radius_m);
  const ContactSearch search{duration_s, kContactMargin * smaller};
  const Eigen::Vector3d between = body.world_from_body.position_m - other.world_from_body.position_m;
  const double motion = duration_s * max_approach_m_s(body, other);
  const double reach =
      body.shape.bounding_radius_m + other.shape.bounding_radius_m + motion + search.margin_m;
  if (between.squaredNorm() > reach * reach) return;

  ContactPair pair = pair_of(body, &other, other.restitution, gravity_m_s2, duration_s);
  pair.other = &other;
  pair.other_id = other.body_id();
  pair.lasts = body.shape.convex && other.shape.convex && !body.shape.round && !other.shape.round;
  if (!without(Mechanism::ReusedManifolds) && pair.lasts && motion < search.margin_m &&
      reuse_manifold(body, pair))
    return;
  candidates.clear();
  if (body.shape.is_ball()) {
    ball_body_candidates(body, other, search, candidates);
  } else if (body.shape.convex && other.shape.convex) {
    polyhedron_candidates(moving_polyhedron(body), moving_polyhedron(other), search, candidates);
  } else if (!separate_coincident(body, other, candidates)) {
    mesh_candidates(body, other, search, candidates);
    separate_deep_overlap(between, smaller, candidates);
    std::vector<ContactCandidate> cores = core_candidates_of_pair(body, other, search);
    if (!cores.empty() && !without(Mechanism::BodyCores)) append_manifolds(body, pair, cores);
  }
  move_to_round_surface(body, PairSide::First, candidates);
  move_to_round_surface(other, PairSide::Other, candidates);
  if (!candidates.empty()) append_manifolds(body, pair, candidates);
}

}  // namespace

void find_contacts(RigidBody& body, std::span<const Collider> colliders, double gravity_m_s2,
                   double duration_s) {
  std::swap(body.manifolds, body.previous_manifolds);
  body.manifolds.clear();
  std::vector<ContactCandidate> candidates;
  if (body.asleep) {
    for (const ContactManifold& manifold : body.previous_manifolds) {
      if (!manifold.other || manifold.other->asleep) body.manifolds.push_back(manifold);
    }
  } else {
    find_collider_contacts(body, colliders, gravity_m_s2, duration_s, candidates);
  }
  for (RigidBody* other : body.near) {
    if (!body.asleep || !other->asleep)
      find_pair_contacts(body, *other, gravity_m_s2, duration_s, candidates);
  }
}

}  // namespace livegs
