// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/rigid_find_contacts.h"

#include <algorithm>
#include <cmath>

#include "physics/rigid_collider_features.h"
#include "physics/rigid_patches.h"
#include "physics/rigid_sweep.h"

namespace livegs {
namespace {

constexpr double kMaxPushSpeed_m_s = 3.0;
constexpr double kPushSizesPerSecond = 5.0;       // bounding diameters a second
constexpr double kRestitutionDrop = 0.01;         // a fall of this part of the bounding radius does not bounce
constexpr uint64_t kBallFeature = kForeignFeature;
constexpr uint64_t kAheadFeature = kBallFeature + 1;

// A field's distance beyond its grid may exceed the true one by up to the square root of 2 (the way to the grid and
// from there on, in place of the straight line).
double marching_factor(const Collider& collider) {
  return std::holds_alternative<FieldShape>(collider.shape) ? 0.7 : 1.0;
}

double margin_m(const RigidBody& body) { return kContactMargin * body.shape.bounding_radius_m; }

ContactPair pair_of(const RigidBody& body, double friction, double restitution, double gravity_m_s2,
                    double duration_s) {
  ContactPair pair;
  pair.friction = mixed_friction(body.friction, friction);
  pair.restitution = mixed_restitution(body.restitution, restitution);
  const double size = body.shape.bounding_radius_m;
  pair.restitution_speed_m_s = std::max({2.0 * gravity_m_s2 * duration_s,
                                         std::sqrt(2.0 * gravity_m_s2 * kRestitutionDrop * size),
                                         sleep_speed_m_s(body.shape)});
  pair.push_speed_m_s = std::min(kMaxPushSpeed_m_s, kPushSizesPerSecond * 2.0 * size);
  return pair;
}

// A ball against any surface: where it touches now, and what lies ahead if it is fast.
template <class Sample>
void ball_candidates(const RigidBody& ball, const Sample& sample, const Eigen::Vector3d& relative_velocity,
                     double marching, double duration_s, std::vector<ContactCandidate>& candidates) {
  const double radius = ball.shape.sphere_radius_m;
  const Eigen::Vector3d& centre = ball.world_from_body.position_m;
  const Eigen::Vector3d way = duration_s * relative_velocity;
  const SurfaceSample here = sample(centre);
  const double gap = here.distance_m - radius;
  if (marching * here.distance_m - radius > way.norm() + margin_m(ball)) return;
  if (gap < margin_m(ball)) {
    candidates.push_back({kBallFeature, centre - radius * here.normal, here.normal, gap});
  }
  const double slack = way.norm() + std::min(0.0, way.dot(here.normal));
  if (gap < margin_m(ball) && slack < 0.5 * radius) return;
  const auto bounded = [&](const Eigen::Vector3d& point) {
    SurfaceSample surface = sample(point);
    if (surface.distance_m > 0.0) surface.distance_m = radius + marching * (surface.distance_m - radius);
    return surface;
  };
  const auto hit = sweep_sphere(bounded, centre, way, radius, 0.1 * margin_m(ball));
  if (!hit) return;
  if (!candidates.empty() && hit->normal.dot(candidates.front().normal) > kPatchNormalCosine) return;
  candidates.push_back({kAheadFeature, centre - radius * hit->normal, hit->normal, hit->separation_m});
}

void point_candidates(const RigidBody& body, const Collider& collider, double duration_s,
                      std::vector<ContactCandidate>& candidates) {
  const double margin = margin_m(body);
  const double marching = marching_factor(collider);
  const Eigen::Matrix3d rotation = body.world_from_body.orientation.toRotationMatrix();
  const auto sample = [&](const Eigen::Vector3d& point) {
    SurfaceSample surface = sample_surface(collider, point);
    if (surface.distance_m > 0.0) surface.distance_m *= marching;
    return surface;
  };
  for (size_t i = 0; i < body.shape.contact_points_m.size(); ++i) {
    const Eigen::Vector3d arm = rotation * body.shape.contact_points_m[i];
    const Eigen::Vector3d point = body.world_from_body.position_m + arm;
    const SurfaceSample here = sample_surface(collider, point);
    if (here.distance_m < margin) {
      candidates.push_back({i, point, here.normal, here.distance_m});
      continue;
    }
    const Eigen::Vector3d way = duration_s * body.point_velocity(arm);
    if (marching * here.distance_m > way.norm()) continue;
    if (std::holds_alternative<PlaneShape>(collider.shape)) {
      if (-way.dot(here.normal) > here.distance_m) candidates.push_back({i, point, here.normal, here.distance_m});
    } else if (const auto hit = sweep_sphere(sample, point, way, 0.0, 0.1 * margin)) {
      candidates.push_back({i, point, hit->normal, hit->separation_m});
    }
  }
}

void feature_candidates(const RigidBody& body, const Collider& collider, double duration_s,
                        std::vector<ContactCandidate>& candidates) {
  const double reach = body.shape.bounding_radius_m;
  const Eigen::Quaterniond& orientation = body.world_from_body.orientation;
  const double motion = duration_s * (body.velocity_m_s.norm() + body.angular_velocity_rad_s.norm() * reach);
  for (const ColliderFeature& feature : collider_features(collider, body.world_from_body.position_m,
                                                          reach + motion + margin_m(body),
                                                          body.shape.contact_spacing_m)) {
    const Eigen::Vector3d arm = feature.point_m - body.world_from_body.position_m;
    const auto sample = [&](const Eigen::Vector3d& from_centre) {
      const DistanceField::Sample field = body.shape.sample(orientation.conjugate() * from_centre);
      return SurfaceSample{field.distance_m, orientation * field.gradient};
    };
    const SurfaceSample here = sample(arm);
    const double gap = here.distance_m - feature.radius_m;
    // Seen from the body, the feature comes towards it.
    const Eigen::Vector3d way = -duration_s * body.point_velocity(arm);
    if (gap < margin_m(body)) {
      candidates.push_back(
          {feature.id, feature.point_m - feature.radius_m * here.normal, -here.normal, gap});
    } else if (gap < way.norm()) {
      const auto hit = sweep_sphere(sample, arm, way, feature.radius_m, 0.1 * margin_m(body));
      if (hit) {
        candidates.push_back(
            {feature.id, feature.point_m - feature.radius_m * hit->normal, -hit->normal, hit->separation_m});
      }
    }
  }
}

void find_collider_contacts(RigidBody& body, std::span<const Collider> colliders, double gravity_m_s2,
                            double duration_s, std::vector<ContactCandidate>& candidates) {
  for (size_t index = 0; index < colliders.size(); ++index) {
    const Collider& collider = colliders[index];
    candidates.clear();
    if (body.shape.is_ball()) {
      ball_candidates(
          body, [&](const Eigen::Vector3d& point) { return sample_surface(collider, point); }, body.velocity_m_s,
          marching_factor(collider), duration_s, candidates);
    } else {
      const double reach = body.shape.bounding_radius_m;
      const double motion = duration_s * (body.velocity_m_s.norm() + body.angular_velocity_rad_s.norm() * reach);
      const double distance = sample_surface(collider, body.world_from_body.position_m).distance_m;
      if (marching_factor(collider) * distance > reach + motion + margin_m(body)) continue;
      point_candidates(body, collider, duration_s, candidates);
      feature_candidates(body, collider, duration_s, candidates);
    }
    if (candidates.empty()) continue;
    ContactPair pair = pair_of(body, collider.friction, collider.restitution, gravity_m_s2, duration_s);
    pair.other_id = kColliderBit + index;
    append_patches(body, pair, duration_s, candidates);
  }
}

// Sleepers keep what they lie on: it is known when one of them goes, and warm when they wake.
void keep_patches(RigidBody& body, uint64_t other_id) {
  for (const ContactPatch& patch : body.previous_patches) {
    if (patch.other_id == other_id) body.patches.push_back(patch);
  }
}

void find_ball_contacts(RigidBody& ball, std::span<RigidBody* const> bodies, double gravity_m_s2,
                        double duration_s, std::vector<ContactCandidate>& candidates) {
  for (RigidBody* other : bodies) {
    if (other == &ball || (other->shape.is_ball() && other->contact_id() < ball.contact_id())) continue;
    if (ball.asleep && other->asleep) {
      keep_patches(ball, other->contact_id());
      continue;
    }
    const Pose& pose = other->world_from_body;
    const Eigen::Vector3d between = ball.world_from_body.position_m - pose.position_m;
    const double reach = ball.shape.bounding_radius_m + other->shape.bounding_radius_m;
    const double motion =
        duration_s * (ball.velocity_m_s.norm() + other->velocity_m_s.norm() +
                      other->angular_velocity_rad_s.norm() * other->shape.bounding_radius_m);
    if (between.norm() > reach + motion + margin_m(ball)) continue;

    candidates.clear();
    const auto sample = [&](const Eigen::Vector3d& point) {
      const DistanceField::Sample field =
          other->shape.sample(pose.orientation.conjugate() * (point - pose.position_m));
      return SurfaceSample{field.distance_m, pose.orientation * field.gradient};
    };
    const Eigen::Vector3d velocity = ball.velocity_m_s - other->point_velocity(between);
    ball_candidates(ball, sample, velocity, 1.0, duration_s, candidates);
    if (candidates.empty()) continue;
    ContactPair pair = pair_of(ball, other->friction, other->restitution, gravity_m_s2, duration_s);
    pair.other = other;
    pair.other_id = other->contact_id();
    append_patches(ball, pair, duration_s, candidates);
  }
}

}  // namespace

void find_contacts(RigidBody& body, std::span<const Collider> colliders, std::span<RigidBody* const> bodies,
                   double gravity_m_s2, double duration_s) {
  std::swap(body.patches, body.previous_patches);
  body.patches.clear();
  std::vector<ContactCandidate> candidates;
  if (body.asleep) {
    for (size_t index = 0; index < colliders.size(); ++index) keep_patches(body, kColliderBit + index);
  } else {
    find_collider_contacts(body, colliders, gravity_m_s2, duration_s, candidates);
  }
  if (body.shape.is_ball()) find_ball_contacts(body, bodies, gravity_m_s2, duration_s, candidates);
}

}  // namespace livegs
