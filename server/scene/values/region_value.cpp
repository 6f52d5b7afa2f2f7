// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/values/region_value.h"

#include "analysis/estimate.h"
#include "scene/values/motion_value.h"
#include "scene/values/scene_values.h"

namespace livegs {
namespace {

// Limit of a traction, pascals; well above the yield stress of steel.
constexpr double kMaxTraction_pa = 1e9;

Error refusal(const std::string& field, const std::string& why) {
  return invalid_argument(field + ": " + why);
}

Result<void> read_box(const v1::Region& region, const std::string& field, BodyRegion& body) {
  body.boundary = region.boundary();
  if (body.boundary && region.has_box())
    return refusal(field + ".boundary", "conflicts with box; give one of them");
  if (body.boundary && !region.has_motion()) {
    return refusal(field + ".boundary", "needs a motion; give a motion, or a box");
  }
  if (!body.boundary && !region.has_box()) {
    return refusal(field + ".box", "is missing; give min_m and max_m, or {} for the whole object");
  }
  const Eigen::Vector3d open = Eigen::Vector3d::Constant(kMaxCoordinate);
  auto low = vector_value(region.box().min_m(), -open, field + ".box.min_m");
  if (!low) return low.error();
  auto high = vector_value(region.box().max_m(), open, field + ".box.max_m");
  if (!high) return high.error();
  for (int axis = 0; axis < 3; ++axis) {
    if ((*low)[axis] <= (*high)[axis]) continue;
    return refusal(field + ".box", std::string("has min_m above max_m along ") + "xyz"[axis] + "; swap them");
  }
  body.min_m = *low;
  body.max_m = *high;
  return {};
}

Result<RegionMaterial> material_value(const v1::Physics& written, const std::string& field) {
  const std::pair<const char*, bool> meaningless[] = {
      {"behavior", written.behavior() != v1::Physics::AUTO},
      {"mass_kg", written.has_mass_kg()},
      {"fill", written.fill() != v1::Physics::FILL_UNKNOWN},
      {"wall_thickness_m", written.has_wall_thickness_m()},
      {"structure_coefficient", written.has_structure_coefficient()},
      {"deformation_resistance", written.has_deformation_resistance()},
      {"damping", written.has_damping()},
      {"fragile", written.has_fragile()},
      {"break_impulse_n_s", written.has_break_impulse_n_s()},
      {"fracture_pieces", written.has_fracture_pieces()},
      {"interior_rgb", written.interior_rgb_size() > 0},
      {"restitution", written.has_restitution()},
  };
  for (const auto& [name, given] : meaningless) {
    if (!given) continue;
    return refusal(field + "." + name,
                   "is not supported in a region; give it in the object's physics, a region accepts "
                   "youngs_modulus_pa, poisson_ratio, density_kg_m3, plasticity and friction");
  }
  if (auto checked = check_scene_physics(written); !checked) {
    return Error{checked.error().code, field + "." + checked.error().message};
  }
  RegionMaterial material;
  if (written.has_youngs_modulus_pa()) material.youngs_modulus_pa = written.youngs_modulus_pa();
  if (written.has_poisson_ratio()) material.poisson_ratio = written.poisson_ratio();
  if (written.has_density_kg_m3()) material.density_kg_m3 = written.density_kg_m3();
  if (written.has_plasticity()) material.plasticity = written.plasticity();
  if (written.has_friction()) material.friction = written.friction();
  return material;
}

}  // namespace

Result<BodyRegion> region_value(const v1::Region& region, const std::string& field) {
  BodyRegion body;
  body.name = region.name();
  body.fixed = region.fixed();
  if (auto read = read_box(region, field, body); !read) return read.error();
  if (region.has_motion()) {
    if (body.fixed) return refusal(field + ".motion", "conflicts with fixed; give one of them");
    auto motion = motion_value(region.motion(), field + ".motion");
    if (!motion) return motion.error();
    body.motion = std::move(*motion);
  }
  if (region.has_material()) {
    auto material = material_value(region.material(), field + ".material");
    if (!material) return material.error();
    body.material = *material;
  }
  auto traction =
      vector_value(region.traction_pa(), Eigen::Vector3d::Zero(), field + ".traction_pa", kMaxTraction_pa);
  if (!traction) return traction.error();
  body.traction_pa = *traction;
  if (body.boundary && (body.material || !body.traction_pa.isZero(0.0))) {
    return refusal(field + ".boundary", "supports a motion only; give a box for a material or a traction");
  }
  if (!body.fixed && !body.motion && !body.material && body.traction_pa.isZero(0.0)) {
    return refusal(field, "has no effect; give fixed, motion, material or traction_pa, or omit the region");
  }
  return body;
}

}  // namespace livegs
