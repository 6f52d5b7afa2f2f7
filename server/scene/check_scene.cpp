// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/check_scene.h"

#include <filesystem>
#include <set>

#include "scene/scene_values.h"

namespace livegs {
namespace {

constexpr double kLargestSize_m = 1000.0;

Error missing(const std::string& field, const std::string& remedy) {
  return invalid_argument(field + ": " + remedy);
}

#define LIVEGS_CHECK(expression) \
  if (auto checked = (expression); !checked) return checked.error()

Result<void> check_box(const v1::BoxShape& box, const std::string& field) {
  if (box.size_m().empty()) return missing(field + ".size_m", "is missing; give [x, y, z] in metres");
  LIVEGS_CHECK(vector_value(box.size_m(), Eigen::Vector3d::Zero(), field + ".size_m"));
  for (double edge : box.size_m()) LIVEGS_CHECK(number_value(edge, 1e-4, kLargestSize_m, field + ".size_m"));
  return {};
}

Result<void> check_collider(const v1::Collider& collider, const std::string& field) {
  switch (collider.shape_case()) {
    case v1::Collider::kPlane: {
      LIVEGS_CHECK(
          vector_value(collider.plane().point_m(), Eigen::Vector3d::Zero(), field + ".plane.point_m"));
      auto normal =
          vector_value(collider.plane().normal(), Eigen::Vector3d::UnitY(), field + ".plane.normal");
      if (!normal) return normal.error();
      if (normal->norm() < 1e-6) return missing(field + ".plane.normal", "is zero; give a direction");
      break;
    }
    case v1::Collider::kBox:
      LIVEGS_CHECK(check_box(collider.box(), field + ".box"));
      break;
    case v1::Collider::kSphere:
      LIVEGS_CHECK(
          number_value(collider.sphere().radius_m(), 1e-4, kLargestSize_m, field + ".sphere.radius_m"));
      break;
    case v1::Collider::kMesh:
      break;
    case v1::Collider::SHAPE_NOT_SET:
      return missing(field, "has no shape; give plane, box, sphere or mesh");
  }
  LIVEGS_CHECK(pose_value(collider.pose(), field + ".pose"));
  if (collider.has_friction()) LIVEGS_CHECK(number_value(collider.friction(), 0, 2, field + ".friction"));
  if (collider.has_restitution())
    LIVEGS_CHECK(number_value(collider.restitution(), 0, 1, field + ".restitution"));
  return {};
}

Result<void> check_shape(const v1::Shape& shape, const std::string& field) {
  const auto check_round = [&](const v1::CylinderShape& round, const std::string& name) -> Result<void> {
    LIVEGS_CHECK(number_value(round.radius_m(), 1e-4, kLargestSize_m, name + ".radius_m"));
    LIVEGS_CHECK(number_value(round.height_m(), 1e-4, kLargestSize_m, name + ".height_m"));
    return {};
  };
  switch (shape.kind_case()) {
    case v1::Shape::kBox:
      return check_box(shape.box(), field + ".box");
    case v1::Shape::kSphere:
      LIVEGS_CHECK(number_value(shape.sphere().radius_m(), 1e-4, kLargestSize_m, field + ".sphere.radius_m"));
      return {};
    case v1::Shape::kCylinder:
      return check_round(shape.cylinder(), field + ".cylinder");
    case v1::Shape::kCapsule:
      return check_round(shape.capsule(), field + ".capsule");
    case v1::Shape::KIND_NOT_SET:
      return missing(field, "is empty; give box, sphere, cylinder or capsule");
  }
  return {};
}

Result<void> check_object(const v1::Object& object, const std::string& field) {
  switch (object.form_case()) {
    case v1::Object::kAsset:
    case v1::Object::kPoints:
      break;
    case v1::Object::kShape:
      LIVEGS_CHECK(check_shape(object.shape(), field + ".shape"));
      break;
    case v1::Object::FORM_NOT_SET:
      return missing(field, "has no form; give asset, shape or points");
  }
  if (object.has_scale()) LIVEGS_CHECK(number_value(object.scale(), 1e-6, 1e6, field + ".scale"));
  LIVEGS_CHECK(up_value(object.up(), field + ".up"));
  LIVEGS_CHECK(pose_value(object.pose(), field + ".pose"));
  LIVEGS_CHECK(vector_value(object.velocity_m_s(), Eigen::Vector3d::Zero(), field + ".velocity_m_s"));
  LIVEGS_CHECK(vector_value(object.angular_velocity_rad_s(), Eigen::Vector3d::Zero(),
                            field + ".angular_velocity_rad_s"));
  if (object.has_spacing_m()) LIVEGS_CHECK(number_value(object.spacing_m(), 1e-4, 10, field + ".spacing_m"));
  for (int i = 0; i < object.regions_size(); ++i) {
    const std::string name = field + ".regions[" + std::to_string(i) + "]";
    const v1::Region& region = object.regions(i);
    if (!region.has_box()) return missing(name + ".box", "is missing");
    auto low = vector_value(region.box().min_m(), Eigen::Vector3d::Constant(-kLargestCoordinate),
                            name + ".box.min_m");
    if (!low) return low.error();
    auto high = vector_value(region.box().max_m(), Eigen::Vector3d::Constant(kLargestCoordinate),
                             name + ".box.max_m");
    if (!high) return high.error();
    if (!(low->array() <= high->array()).all()) return missing(name + ".box", "has min_m above max_m");
    if (!region.fixed()) return missing(name + ".fixed", "is false; a region that does nothing is left out");
  }
  return {};
}

Result<void> check_event(const v1::Event& event, const std::set<std::string>& names,
                         const std::string& field) {
  LIVEGS_CHECK(number_value(event.time_s(), 0, 1e6, field + ".time_s"));
  const auto check_target = [&](const std::string& object, const std::string& name) -> Result<void> {
    if (names.contains(object)) return {};
    return missing(name + ".object", "no object is called \"" + object + "\"");
  };
  switch (event.action_case()) {
    case v1::Event::kForce: {
      const v1::Event::Force& force = event.force();
      LIVEGS_CHECK(check_target(force.object(), field + ".force"));
      LIVEGS_CHECK(vector_value(force.point_m(), Eigen::Vector3d::Zero(), field + ".force.point_m"));
      if (force.force_n().empty())
        return missing(field + ".force.force_n", "is missing; give [x, y, z] in newtons");
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
      return check_target(event.set_physics().object(), field + ".set_physics");
    case v1::Event::ACTION_NOT_SET:
      return missing(field, "does nothing; give force, ball or set_physics");
  }
  return {};
}

}  // namespace

std::string object_name(const v1::Object& object, int index) {
  if (!object.name().empty()) return object.name();
  std::filesystem::path file;
  if (object.form_case() == v1::Object::kAsset) file = object.asset();
  if (object.form_case() == v1::Object::kPoints) file = object.points();
  if (file.filename() == "meta.json") file = file.parent_path();
  std::string stem = file.stem().string();
  if (stem.ends_with(".compressed")) stem.resize(stem.size() - std::string(".compressed").size());
  return stem.empty() ? "object " + std::to_string(index) : stem;
}

Result<void> check_scene(const v1::Scene& scene) {
  LIVEGS_CHECK(vector_value(scene.gravity_m_s2(), Eigen::Vector3d::Zero(), "gravity_m_s2"));
  if (scene.has_rate_hz()) LIVEGS_CHECK(number_value(scene.rate_hz(), 1, 1000, "rate_hz"));
  if (scene.has_substeps()) LIVEGS_CHECK(number_value(scene.substeps(), 1, 1024, "substeps"));
  const v1::Environment& environment = scene.environment();
  if (environment.has_scale())
    LIVEGS_CHECK(number_value(environment.scale(), 1e-6, 1e6, "environment.scale"));
  LIVEGS_CHECK(up_value(environment.up(), "environment.up"));
  LIVEGS_CHECK(pose_value(environment.pose(), "environment.pose"));
  if (environment.collide() && environment.asset().empty()) {
    return missing("environment.asset", "is missing, but environment.collide is true");
  }
  for (int i = 0; i < environment.colliders_size(); ++i) {
    LIVEGS_CHECK(
        check_collider(environment.colliders(i), "environment.colliders[" + std::to_string(i) + "]"));
  }
  std::set<std::string> names;
  for (int i = 0; i < scene.objects_size(); ++i) {
    const std::string field = "objects[" + std::to_string(i) + "]";
    LIVEGS_CHECK(check_object(scene.objects(i), field));
    const std::string name = object_name(scene.objects(i), i);
    if (!names.insert(name).second)
      return missing(field + ".name", "\"" + name + "\" stands twice; names are unique");
  }
  for (int i = 0; i < scene.events_size(); ++i) {
    LIVEGS_CHECK(check_event(scene.events(i), names, "events[" + std::to_string(i) + "]"));
  }
  return {};
}

}  // namespace livegs
