// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/check/check_object.h"

#include <algorithm>
#include <filesystem>
#include <set>

#include "analysis/estimate.h"
#include "analysis/knowledge/tables.h"
#include "core/text/shown_text.h"
#include "gaussian/asset_name.h"
#include "scene/check/check_scene.h"
#include "scene/values/region_value.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

Error missing(const std::string& field, const std::string& remedy) {
  return invalid_argument(field + ": " + remedy);
}

// Limits the work that a malicious file can cause: a body is cut at each region.
constexpr int kMaxRegions = 256;

#define LIVEGS_CHECK(expression) \
  if (auto checked = (expression); !checked) return checked.error()

Result<void> check_shape(const v1::Shape& shape, const std::string& field) {
  const auto check_round = [&](const v1::CylinderShape& round, const std::string& name) -> Result<void> {
    LIVEGS_CHECK(number_value(round.radius_m(), 1e-4, kMaxSize_m, name + ".radius_m"));
    LIVEGS_CHECK(number_value(round.height_m(), 1e-4, kMaxSize_m, name + ".height_m"));
    return {};
  };
  switch (shape.kind_case()) {
    case v1::Shape::kBox:
      return check_box_shape(shape.box(), field + ".box");
    case v1::Shape::kSphere:
      LIVEGS_CHECK(number_value(shape.sphere().radius_m(), 1e-4, kMaxSize_m, field + ".sphere.radius_m"));
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

// Refuses regions and initial deformations on objects that are not elastic.
Result<void> check_deformable(const v1::Object& object, const std::string& field) {
  const v1::Physics::Behavior behavior = object.physics().behavior();
  if (behavior == v1::Physics::AUTO || behavior == v1::Physics::ELASTIC) return {};
  const std::string why = "is only for elastic objects, and this object is " +
                          v1::Physics::Behavior_Name(behavior) + "; set physics.behavior to ELASTIC";
  if (object.regions_size() > 0) return missing(field + ".regions", why);
  if (!object.initial_deformation().empty()) return missing(field + ".initial_deformation", why);
  if (object.has_resolution()) return missing(field + ".resolution", why);
  return {};
}

Result<void> check_material(const std::string& name, const std::string& field) {
  if (name.empty()) return {};
  const std::vector<MaterialRow>& table = material_table();
  if (std::any_of(table.begin(), table.end(), [&](const MaterialRow& row) { return row.name == name; }))
    return {};
  std::string known;
  for (const MaterialRow& row : table) {
    if (row.name.find(name) != std::string::npos || name.find(row.name) != std::string::npos)
      known += (known.empty() ? "" : ", ") + row.name;
  }
  return missing(
      field, quoted_name(name) + " is not in the material table" +
                 (known.empty() ? "; see server/analysis/knowledge/materials.csv" : "; similar: " + known));
}

Result<void> check_standing(const v1::Object& object, const std::string& field) {
  if (object.has_assumed_scale())
    LIVEGS_CHECK(number_value(object.assumed_scale(), 1e-6, 1e6, field + ".assumed_scale"));
  if (!object.standing()) return {};
  if (object.form_case() != v1::Object::kAsset)
    return missing(field + ".standing", "is only for assets; shapes and points are exact as they are");
  if (object.velocity_m_s_size() > 0 || object.angular_velocity_rad_s_size() > 0)
    return missing(field + ".standing", "conflicts with a velocity; omit one of them");
  if (!object.initial_deformation().empty() || object.regions_size() > 0)
    return missing(field + ".standing", "conflicts with initial_deformation and regions; omit one of them");
  return {};
}

Result<void> check_resolution(const v1::Object& object, const std::string& field) {
  const v1::Resolution& resolution = object.resolution();
  if (resolution.has_cell_width_m())
    LIVEGS_CHECK(number_value(resolution.cell_width_m(), 1e-4, 10, field + ".cell_width_m"));
  if (resolution.has_substeps())
    LIVEGS_CHECK(number_value(resolution.substeps(), 1, kMaxSubsteps, field + ".substeps"));
  if (!resolution.has_budget_ms()) return {};
  if (resolution.has_cell_width_m())
    return missing(field + ".budget_ms",
                   "conflicts with cell_width_m, which fixes the cost; omit one of them");
  LIVEGS_CHECK(number_value(resolution.budget_ms(), 0.001, 1000, field + ".budget_ms"));
  return {};
}

Result<void> check_regions(const v1::Object& object, const std::string& field) {
  if (object.regions_size() > kMaxRegions) {
    return missing(field + ".regions", "has " + std::to_string(object.regions_size()) +
                                           " entries; give at most " + std::to_string(kMaxRegions));
  }
  std::set<std::string> names;
  for (int i = 0; i < object.regions_size(); ++i) {
    const v1::Region& region = object.regions(i);
    const std::string name = field + ".regions[" + std::to_string(i) + "]";
    const auto fail = [&](const Error& error) {
      return Error{error.code, region.name().empty()
                                   ? error.message
                                   : "region " + quoted_name(region.name()) + ": " + error.message};
    };
    if (auto checked = region_value(region, name); !checked) return fail(checked.error());
    if (!region.name().empty() && !names.insert(region.name()).second) {
      return fail(missing(name + ".name", "is used twice; names must be unique within an object"));
    }
    if (region.material().has_density_kg_m3() && object.physics().has_mass_kg()) {
      return fail(missing(
          name + ".material.density_kg_m3",
          "conflicts with " + field + ".physics.mass_kg; give " + field + ".physics.density_kg_m3 instead"));
    }
  }
  return {};
}

}  // namespace

Result<void> check_box_shape(const v1::BoxShape& box, const std::string& field) {
  if (box.size_m().empty()) return missing(field + ".size_m", "is missing; give [x, y, z] in metres");
  LIVEGS_CHECK(vector_value(box.size_m(), Eigen::Vector3d::Zero(), field + ".size_m"));
  for (double edge : box.size_m()) LIVEGS_CHECK(number_value(edge, 1e-4, kMaxSize_m, field + ".size_m"));
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
  if (object.has_kernel_per_point() && object.form_case() != v1::Object::kPoints) {
    return missing(field + ".kernel_per_point", "is only for points; omit it");
  }
  LIVEGS_CHECK(check_material(object.material(), field + ".material"));
  LIVEGS_CHECK(matrix_value(object.initial_deformation(), field + ".initial_deformation"));
  if (auto checked = check_scene_physics(object.physics()); !checked) {
    return Error{checked.error().code, field + ".physics." + checked.error().message};
  }
  LIVEGS_CHECK(check_deformable(object, field));
  LIVEGS_CHECK(check_resolution(object, field + ".resolution"));
  LIVEGS_CHECK(check_standing(object, field));
  return check_regions(object, field);
}

std::string object_name(const v1::Object& object, int index) {
  if (!object.name().empty()) return object.name();
  std::filesystem::path file;
  if (object.form_case() == v1::Object::kAsset) file = object.asset();
  if (object.form_case() == v1::Object::kPoints) file = object.points();
  std::string stem = asset_stem(file).filename().string();
  if (!is_asset_index(file) && !asset_ending(file.string())) stem = file.stem().string();
  return stem.empty() ? "object " + std::to_string(index) : stem;
}

Error of_object(const Error& error, const std::string& name) {
  return {error.code, "object " + quoted_name(name) + ": " + error.message};
}

#undef LIVEGS_CHECK

}  // namespace livegs
