// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "core/assert.h"
#include "physics/world/world_state.h"

namespace livegs {
namespace {

// Objects up to this distance behind a collider's surface are still hit, m: resting objects overlap slightly.
constexpr double kSurfaceTolerance_m = 0.005;
constexpr double kSunk_m = 0.05;  // a point deeper in a collider counts as beyond a wall (distance_down_m)

// Distance to a collider, or `most_m` if it is not hit before. Colliders that contain the ray's start are
// ignored: a camera may be behind a wall.
double way_to(const Collider& collider, const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
              double most_m) {
  const ColliderProbe probe(collider);
  const SurfaceSample start = probe.sample(origin_m);
  if (!(start.distance_m > 0.0)) return most_m;
  if (std::holds_alternative<PlaneShape>(collider.shape)) {
    const double nearing = -start.normal.dot(direction);
    return nearing > 0.0 ? std::min(most_m, start.distance_m / nearing) : most_m;
  }
  double way = 0.0;
  for (int march = 0; march < 4096 && way < most_m; ++march) {
    const double free = probe.sample(origin_m + way * direction).distance_m;
    if (!(free > 0.0)) return way;
    way += std::max(kFieldMarchFactor * free, 0.001 /* at least */);
  }
  return most_m;
}

}  // namespace

std::optional<RayHit> World::ray_cast(const Eigen::Vector3d& origin_m, const Eigen::Vector3d& direction,
                                      double max_distance_m) const {
  std::optional<RayHit> nearest;
  const RigidObject* met = nullptr;  // if the hit is a rigid object; met_index is its body
  size_t met_index = 0;
  const auto offer = [&](uint32_t id, double distance, const Eigen::Vector3d& rest_point,
                         const RigidObject* rigid = nullptr, size_t index = 0) {
    if (distance > max_distance_m || (nearest && nearest->distance_m <= distance)) return;
    nearest = RayHit{id, distance, rest_point, {}};
    met = rigid;
    met_index = index;
  };
  for (const auto& [id, object] : state_->objects) {
    if (const RigidObject* rigid = object.rigid()) {
      for (const auto& body : rigid->bodies) {
        const auto distance = livegs::ray_cast(*body, origin_m, direction);
        if (!distance) continue;
        // For fragments, a point slightly inside, to distinguish it from pieces beyond the cut faces.
        const double depth = rigid->bodies.size() == 1 ? 0.0 : 1e-5 * body->shape.bounding_radius_m;
        const Eigen::Vector3d point = origin_m + (*distance + depth) * direction;
        offer(id, *distance, body->world_from_body.inverse() * point + body->rest_centre_m, rigid,
              body->body_index);
      }
    } else if (const ElasticObject* elastic = object.elastic()) {
      if (const auto hit = elastic->body->ray_cast(origin_m, direction)) {
        offer(id, hit->distance_m, hit->rest_point_m);
      }
    }
  }
  if (!nearest) return nearest;
  const double before_m = nearest->distance_m - kSurfaceTolerance_m;
  for (const Collider& collider : state_->colliders) {
    if (way_to(collider, origin_m, direction, before_m) < before_m) return std::nullopt;
  }
  if (met) nearest->piece = met->piece_nearest_to(met_index, nearest->rest_point_m);
  return nearest;
}

std::optional<double> World::distance_down_m(uint32_t object_id, double max_distance_m) const {
  const WorldObject* object = state_->find(object_id);
  if (!object || object->fixed()) return std::nullopt;
  const Eigen::Vector3d down = state_->settings.gravity_m_s2.normalized();
  std::vector<Eigen::Vector3d> points_m;
  if (const RigidObject* rigid = object->rigid()) {
    for (const auto& body : rigid->bodies) {
      if (body->shape.is_ball())
        points_m.push_back(body->world_from_body.position_m + body->shape.bounding_radius_m * down);
      for (const Eigen::Vector3d& vertex : body->shape.mesh.vertices_m)
        points_m.push_back(body->world_from_body * vertex);
    }
  } else {
    std::vector<SurfaceElement> elements;
    const ElasticBody& body = *object->elastic()->body;
    body.surface_elements(body.bounds_m(), elements);
    for (const SurfaceElement& element : elements)
      points_m.push_back(element.position_m + element.radius_m * down);
  }
  return distance_down_m(points_m, object_id, max_distance_m);
}

std::optional<double> World::distance_down_m(std::span<const Eigen::Vector3d> points_m,
                                             std::optional<uint32_t> except_object_id,
                                             double max_distance_m) const {
  const Eigen::Vector3d& gravity = state_->settings.gravity_m_s2;
  if (gravity.norm() == 0.0) return std::nullopt;
  const Eigen::Vector3d down = gravity.normalized();
  const size_t stride = 1 + points_m.size() / kMaxContactPoints;
  if (points_m.empty()) return std::nullopt;
  const Eigen::Vector3d lowest =
      *std::ranges::max_element(points_m, {}, [&](const Eigen::Vector3d& point) { return down.dot(point); });
  double least = max_distance_m;
  for (size_t i = 0; i < points_m.size(); i += stride) {
    const Eigen::Vector3d& point = i == 0 ? lowest : points_m[i];
    for (size_t c = 0; c < state_->colliders.size(); ++c) {
      if (except_object_id && state_->collider_objects[c] == *except_object_id) continue;
      const Collider& collider = state_->colliders[c];
      const double start = ColliderProbe(collider).sample(point).distance_m;
      least = std::min(
          least, start > 0.0 ? way_to(collider, point, down, least) : (start > -kSunk_m ? start : least));
    }
    for (const auto& [id, other] : state_->objects) {
      if (id == except_object_id) continue;
      if (const RigidObject* rigid = other.rigid()) {
        for (const auto& body : rigid->bodies) {
          if (const auto way = livegs::ray_cast(*body, point, down)) least = std::min(least, *way);
        }
      } else if (const ElasticObject* elastic = other.elastic()) {
        if (const auto hit = elastic->body->ray_cast(point, down)) least = std::min(least, hit->distance_m);
      }
    }
  }
  return least < max_distance_m ? std::optional(least) : std::nullopt;
}

Eigen::Vector3d World::world_point(uint32_t object_id, const Eigen::Vector3d& rest_point_m,
                                   std::optional<uint32_t> piece) const {
  const WorldObject* object = state_->find(object_id);
  if (!object) return rest_point_m;
  if (const StaticObject* fixed = object->fixed()) return fixed->world_from_object * rest_point_m;
  if (const RigidObject* rigid = object->rigid()) {
    const RigidBody& body = rigid->body_with(rest_point_m, piece);
    return body.world_from_body * Eigen::Vector3d(rest_point_m - body.rest_centre_m);
  }
  return object->elastic()->body->world_point(rest_point_m);
}

RestBody World::rest_body(uint32_t object_id) const {
  const WorldObject* object = state_->find(object_id);
  LIVEGS_ASSERT(object != nullptr);
  if (const ElasticObject* elastic = object->elastic()) return elastic->body->rest_body();
  RestBody rest;
  rest.kind = DriverKind::Rigid;
  const RigidObject* rigid = object->rigid();
  rest.bodies.resize(rigid ? rigid->bodies.size() : 1);
  if (!rigid) return rest;
  rest.revision = rigid->revision;
  for (size_t i = 0; i < rest.bodies.size(); ++i) rest.bodies[i].position_m = rigid->bodies[i]->rest_centre_m;
  return rest;
}

DriverFrame World::drivers() const {
  DriverFrame frame;
  frame.tick = state_->tick;
  frame.simulated_ns = std::llround(static_cast<double>(state_->tick) * 1e9 / state_->settings.rate_hz);
  for (const auto& [id, object] : state_->objects) {
    ObjectDrivers drivers;
    if (const ElasticObject* elastic = object.elastic()) elastic->body->write_drivers(drivers);
    if (const RigidObject* rigid = object.rigid()) {
      drivers.revision = rigid->revision;
      for (const auto& body : rigid->bodies) drivers.poses.push_back(body->world_from_body);
    }
    if (const StaticObject* fixed = object.fixed()) drivers.poses.push_back(fixed->world_from_object);
    drivers.object_id = id;
    drivers.asleep = object.asleep();
    frame.objects.push_back(std::move(drivers));
  }
  return frame;
}

std::vector<BodyState> World::bodies() const {
  std::vector<BodyState> bodies;
  for (const auto& [id, object] : state_->objects) {
    if (const StaticObject* fixed = object.fixed()) {
      const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
      bodies.push_back({id, 0, fixed->world_from_object, zero, zero, 0.0, true});
    } else if (const RigidObject* rigid = object.rigid()) {
      for (const auto& body : rigid->bodies) {
        bodies.push_back({id, body->body_index, body->world_from_body, body->velocity_m_s,
                          body->angular_velocity_rad_s, body->mass_kg, body->asleep});
      }
    } else {
      const ElasticBody& body = *object.elastic()->body;
      bodies.push_back({id, 0, body.centre_pose(), body.velocity_m_s(), body.angular_velocity_rad_s(),
                        body.mass_kg(), body.asleep()});
    }
  }
  return bodies;
}

const ElasticBody* World::elastic_body(uint32_t object_id) const {
  const WorldObject* object = state_->find(object_id);
  return object && object->elastic() ? object->elastic()->body.get() : nullptr;
}

BodyEnergy World::energy() const {
  BodyEnergy total;
  for (const auto& [id, object] : state_->objects) {
    if (const RigidObject* rigid = object.rigid()) {
      for (const auto& body : rigid->bodies) {
        const Eigen::Vector3d momentum = body->mass_kg * body->velocity_m_s,
                              position = body->world_from_body.position_m;
        total.kinetic_j += body->kinetic_j();
        total.gravity_j -= body->mass_kg * state_->settings.gravity_m_s2.dot(position);
        total.linear_momentum += momentum;
        total.angular_momentum += position.cross(momentum) + body->angular_momentum;
      }
    } else if (const ElasticObject* elastic = object.elastic()) {
      const BodyEnergy energy = elastic->body->energy(state_->settings.gravity_m_s2);
      total.kinetic_j += energy.kinetic_j;
      total.elastic_j += energy.elastic_j;
      total.gravity_j += energy.gravity_j;
      total.linear_momentum += energy.linear_momentum;
      total.angular_momentum += energy.angular_momentum;
    }
  }
  return total;
}

}  // namespace livegs
