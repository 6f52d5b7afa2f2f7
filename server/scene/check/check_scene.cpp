// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/check/check_scene.h"

#include <map>

#include "analysis/estimate.h"
#include "parts/labelled_room.h"
#include "physics/world.h"
#include "scene/check/check_object.h"
#include "scene/check/joint_parts.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

Error missing_field(const std::string& field, const std::string& remedy) {
  return invalid_argument(field + ": " + remedy);
}

#define LIVEGS_CHECK(expression) \
  if (auto checked = (expression); !checked) return checked.error()

// Objects by name.
using Objects = std::map<std::string, const v1::Object*>;

Result<void> check_collider(const v1::Collider& collider, const std::string& field) {
  switch (collider.shape_case()) {
    case v1::Collider::kPlane: {
      LIVEGS_CHECK(
          vector_value(collider.plane().point_m(), Eigen::Vector3d::Zero(), field + ".plane.point_m"));
      auto normal =
          vector_value(collider.plane().normal(), Eigen::Vector3d::UnitY(), field + ".plane.normal");
      if (!normal) return normal.error();
      if (normal->norm() < 1e-6) return missing_field(field + ".plane.normal", "is zero; give a direction");
      break;
    }
    case v1::Collider::kBox:
      LIVEGS_CHECK(check_box_shape(collider.box(), field + ".box"));
      break;
    case v1::Collider::kSphere:
      LIVEGS_CHECK(number_value(collider.sphere().radius_m(), 1e-4, kMaxSize_m, field + ".sphere.radius_m"));
      break;
    case v1::Collider::kMesh:
      break;
    case v1::Collider::SHAPE_NOT_SET:
      return missing_field(field, "has no shape; give plane, box, sphere or mesh");
  }
  LIVEGS_CHECK(pose_value(collider.pose(), field + ".pose"));
  if (collider.has_friction()) LIVEGS_CHECK(number_value(collider.friction(), 0, 2, field + ".friction"));
  if (collider.has_restitution())
    LIVEGS_CHECK(number_value(collider.restitution(), 0, 1, field + ".restitution"));
  return {};
}

Result<void> check_release(const v1::Object& object, const std::string& region_name,
                           const std::string& field) {
  std::string known;
  for (const v1::Region& region : object.regions()) {
    const bool held = region.fixed() || region.has_motion();
    if (!region_name.empty() && region.name() == region_name) {
      if (held) return {};
      return missing_field(field,
                           "\"" + region_name + "\" is neither fixed nor moved; name a region that is");
    }
    if (held && !region.name().empty()) known += (known.empty() ? "" : ", ") + region.name();
  }
  return missing_field(field, "the object has no region called \"" + region_name + "\"; " +
                                  (known.empty() ? "it has no named region that is fixed or moved"
                                                 : "fixed or moved regions: " + known));
}

Result<void> check_event(const v1::Event& event, const Objects& objects, const std::string& field) {
  LIVEGS_CHECK(number_value(event.time_s(), 0, 1e6, field + ".time_s"));
  const auto check_target = [&](const std::string& object, const std::string& name) -> Result<void> {
    if (objects.contains(object)) return {};
    return missing_field(name + ".object",
                         "no object is called \"" + object + "\"; name an object of the scene");
  };
  const auto check_hand = [&](const auto& hand, const std::string& name) -> Result<void> {
    LIVEGS_CHECK(check_target(hand.object(), name));
    LIVEGS_CHECK(vector_value(hand.point_m(), Eigen::Vector3d::Zero(), name + ".point_m"));
    if (objects.at(hand.object())->physics().behavior() == v1::Physics::STATIC) {
      return missing_field(name + ".object",
                           "\"" + hand.object() + "\" is STATIC and cannot be moved; name a moving object");
    }
    if (hand.path().empty())
      return missing_field(name + ".path", "is missing; name a CSV file with the path of the hand");
    return {};
  };
  switch (event.action_case()) {
    case v1::Event::kForce: {
      const v1::Event::Force& force = event.force();
      LIVEGS_CHECK(check_target(force.object(), field + ".force"));
      LIVEGS_CHECK(vector_value(force.point_m(), Eigen::Vector3d::Zero(), field + ".force.point_m"));
      if (force.force_n().empty())
        return missing_field(field + ".force.force_n", "is missing; give [x, y, z] in newtons");
      LIVEGS_CHECK(vector_value(force.force_n(), Eigen::Vector3d::Zero(), field + ".force.force_n"));
      LIVEGS_CHECK(number_value(force.duration_s(), 0, 1e6, field + ".force.duration_s"));
      return {};
    }
    case v1::Event::kBall:
      LIVEGS_CHECK(vector_value(event.ball().from_m(), Eigen::Vector3d::Zero(), field + ".ball.from_m"));
      LIVEGS_CHECK(
          vector_value(event.ball().velocity_m_s(), Eigen::Vector3d::Zero(), field + ".ball.velocity_m_s"));
      return {};
    case v1::Event::kSetPhysics:
      LIVEGS_CHECK(check_target(event.set_physics().object(), field + ".set_physics"));
      if (auto checked = check_scene_physics(event.set_physics().physics()); !checked) {
        return of_object({checked.error().code, field + ".set_physics.physics." + checked.error().message},
                         event.set_physics().object());
      }
      return {};
    case v1::Event::kReleaseRegion: {
      const v1::Event::ReleaseRegion& release = event.release_region();
      LIVEGS_CHECK(check_target(release.object(), field + ".release_region"));
      auto checked =
          check_release(*objects.at(release.object()), release.region(), field + ".release_region.region");
      if (!checked) return of_object(checked.error(), release.object());
      return {};
    }
    case v1::Event::kBreak: {
      LIVEGS_CHECK(check_target(event.break_().object(), field + ".break"));
      LIVEGS_CHECK(vector_value(event.break_().point_m(), Eigen::Vector3d::Zero(), field + ".break.point_m"));
      const v1::Physics& physics = objects.at(event.break_().object())->physics();
      if (physics.has_fragile() && !physics.fragile()) {
        return missing_field(field + ".break.object", "\"" + event.break_().object() +
                                                          "\" is not fragile; set physics.fragile to true");
      }
      return {};
    }
    case v1::Event::kGrab:
      return check_hand(event.grab(), field + ".grab");
    case v1::Event::kPull:
      return check_hand(event.pull(), field + ".pull");
    case v1::Event::ACTION_NOT_SET:
      return missing_field(
          field, "has no action; give force, ball, grab, pull, break, set_physics or release_region");
  }
  return {};
}

}  // namespace

Result<void> check_scene(const v1::Scene& scene) {
  LIVEGS_CHECK(vector_value(scene.gravity_m_s2(), Eigen::Vector3d::Zero(), "gravity_m_s2"));
  if (scene.has_rate_hz()) LIVEGS_CHECK(number_value(scene.rate_hz(), 1, 2000, "rate_hz"));
  if (scene.has_substeps()) LIVEGS_CHECK(number_value(scene.substeps(), 1, kMaxSubsteps, "substeps"));
  if (scene.has_elastic_budget_ms())
    LIVEGS_CHECK(number_value(scene.elastic_budget_ms(), 0.01, 1000, "elastic_budget_ms"));
  const v1::Environment& environment = scene.environment();
  if (environment.has_scale())
    LIVEGS_CHECK(number_value(environment.scale(), 1e-6, 1e6, "environment.scale"));
  LIVEGS_CHECK(up_value(environment.up(), "environment.up"));
  LIVEGS_CHECK(pose_value(environment.pose(), "environment.pose"));
  if (environment.collide() && environment.asset().empty()) {
    return missing_field(
        "environment.asset",
        "is missing, but environment.collide is true; give an asset, or set collide to false");
  }
  if (environment.taken_size() > 0 && environment.labels().empty())
    return missing_field(
        "environment.labels",
        "is missing, but environment.taken names things of the room; give the label file, or remove taken");
  for (const uint32_t label : environment.taken()) {
    if (label < 1 || label > kThingMask)
      return invalid_argument("environment.taken: " + std::to_string(label) +
                              " is not a label; give 1 to 16383");
  }
  for (int i = 0; i < environment.colliders_size(); ++i) {
    LIVEGS_CHECK(
        check_collider(environment.colliders(i), "environment.colliders[" + std::to_string(i) + "]"));
  }
  Objects objects;
  for (int i = 0; i < scene.objects_size(); ++i) {
    const std::string field = "objects[" + std::to_string(i) + "]";
    const std::string name = object_name(scene.objects(i), i);
    if (auto checked = check_object(scene.objects(i), field); !checked)
      return of_object(checked.error(), name);
    const WorldSettings usual;
    const uint32_t substeps = scene.objects(i).resolution().substeps(),
                   asked = scene.has_substeps() ? scene.substeps() : static_cast<uint32_t>(usual.substeps);
    const double rate_hz = scene.has_rate_hz() ? scene.rate_hz() : usual.rate_hz;
    const uint32_t of_scene = std::max(asked, static_cast<uint32_t>(min_substeps(rate_hz)));
    if (substeps % of_scene != 0) {
      return of_object(missing_field(field + ".resolution.substeps",
                                     std::to_string(substeps) + " is not a multiple of the scene's " +
                                         std::to_string(of_scene) + " substeps; give a multiple"),
                       name);
    }
    if (!objects.emplace(name, &scene.objects(i)).second)
      return missing_field(field + ".name", "\"" + name + "\" is used twice; names must be unique");
  }
  for (int i = 0; i < scene.joints_size(); ++i) {
    const auto find = [&](const std::string& name) {
      const auto found = objects.find(name);
      return found == objects.end() ? nullptr : found->second;
    };
    LIVEGS_CHECK(check_joint(scene.joints(i), find, "joints[" + std::to_string(i) + "]"));
  }
  for (int i = 0; i < scene.events_size(); ++i) {
    LIVEGS_CHECK(check_event(scene.events(i), objects, "events[" + std::to_string(i) + "]"));
  }
  return {};
}

}  // namespace livegs
