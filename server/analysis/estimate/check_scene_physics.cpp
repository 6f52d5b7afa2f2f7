// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "analysis/division/part_places.h"
#include "analysis/estimate.h"

namespace livegs {
namespace {

using v1::Physics;

struct Field {
  const char* name;
  bool given;
  double value, low, high;
};

// Density range of materials, from aerogel-like foam to osmium.
constexpr double kMinDensity_kg_m3 = 0.1, kMaxDensity_kg_m3 = 25000;

// Factor outside the estimated range above which an author's value is remarked on. Corrections stay below it,
// slips of units do not.
constexpr double kImplausibleRatio = 10.0;

std::string remark(const char* field, double value, const char* unit, const std::string& instead, double low,
                   double high) {
  char line[320];
  std::snprintf(line, sizeof line, "%s: %g %s is used as written, but %s %.3g to %.3g %s", field, value, unit,
                instead.c_str(), low, high, unit);
  return line;
}

}  // namespace

Result<void> check_scene_physics(const Physics& written) {
  const Field fields[] = {
      {"mass_kg", written.has_mass_kg(), written.mass_kg(), 1e-6, 1e6},
      {"density_kg_m3", written.has_density_kg_m3(), written.density_kg_m3(), kMinDensity_kg_m3,
       kMaxDensity_kg_m3},
      {"wall_thickness_m", written.has_wall_thickness_m(), written.wall_thickness_m(), 1e-6, 10},
      {"youngs_modulus_pa", written.has_youngs_modulus_pa(), written.youngs_modulus_pa(), 1, 1e12},
      {"poisson_ratio", written.has_poisson_ratio(), written.poisson_ratio(), 0, 0.49},
      {"structure_coefficient", written.has_structure_coefficient(), written.structure_coefficient(), 1e-6,
       1},
      {"deformation_resistance", written.has_deformation_resistance(), written.deformation_resistance(), 1e-6,
       1},
      {"plasticity", written.has_plasticity(), written.plasticity(), 0, 1},
      {"damping", written.has_damping(), written.damping(), 0, 2},
      {"break_impulse_n_s", written.has_break_impulse_n_s(), written.break_impulse_n_s(), 1e-6, 1e6},
      {"fracture_pieces", written.has_fracture_pieces(), static_cast<double>(written.fracture_pieces()), 2,
       64},
      {"friction", written.has_friction(), written.friction(), 0, 2},
      {"restitution", written.has_restitution(), written.restitution(), 0, 1},
  };
  for (const Field& field : fields) {
    if (!field.given) continue;
    if (!std::isfinite(field.value) || field.value < field.low || field.value > field.high) {
      char message[160];
      std::snprintf(message, sizeof message, "%s: is %g; it must be between %g and %g", field.name,
                    field.value, field.low, field.high);
      return invalid_argument(message);
    }
  }
  const bool in_range = std::all_of(written.interior_rgb().begin(), written.interior_rgb().end(),
                                    [](double part) { return part >= 0.0 && part <= 1.0; });
  if (const int parts = written.interior_rgb_size(); (parts != 0 && parts != 3) || !in_range) {
    return invalid_argument("interior_rgb: must be three numbers between 0 and 1: red, green and blue");
  }
  // JSON may hold an enumerator as a number, and the parser accepts any number.
  if (!Physics::Behavior_IsValid(written.behavior())) {
    return invalid_argument("behavior: is " + std::to_string(written.behavior()) +
                            "; give AUTO, STATIC, RIGID or ELASTIC");
  }
  if (!Physics::Fill_IsValid(written.fill())) {
    return invalid_argument("fill: is " + std::to_string(written.fill()) +
                            "; give SOLID, SHELL, OPEN_SHELL or FILLED");
  }
  if (written.has_mass_kg() && written.has_density_kg_m3()) {
    return invalid_argument("density_kg_m3: given together with mass_kg; give only one of them");
  }
  if (written.has_youngs_modulus_pa() && written.has_deformation_resistance()) {
    return invalid_argument(
        "deformation_resistance: given together with youngs_modulus_pa; give only one of them");
  }
  return check_parts(written.parts());
}

std::vector<std::string> implausible_physics(const v1::PhysicalParameters& estimated, const Physics& written,
                                             const v1::PhysicalParameters& merged, const ObjectFacts& facts) {
  std::vector<std::string> doubts;
  const auto far_from = [](double value, double low, double high) {
    return value < low / kImplausibleRatio || value > high * kImplausibleRatio;
  };
  const bool telling = estimated.confidence() >= kMaterialNamedConfidence;
  const std::string taken_for = "a " + estimated.label() + " of " + estimated.material() + " has";
  // The author's stiffness is that of the whole body, so it is compared with s E.
  const double stiffness_pa = merged.structure_coefficient().best() * merged.youngs_modulus_pa().best();
  const double low = estimated.structure_coefficient().low() * estimated.youngs_modulus_pa().low();
  const double high = estimated.structure_coefficient().high() * estimated.youngs_modulus_pa().high();
  // A soft shape is intended, such as a cube of jelly; a captured object this soft is a slip.
  const bool too_soft = !facts.solid && stiffness_pa < low / kImplausibleRatio;
  if (telling && written.has_youngs_modulus_pa() && (too_soft || stiffness_pa > high * kImplausibleRatio)) {
    doubts.push_back(remark("youngs_modulus_pa", stiffness_pa, "Pa", taken_for, low, high));
  }
  const v1::EstimatedValue& mass = estimated.mass_kg();
  if (telling && facts.scale_known && (written.has_mass_kg() || written.has_density_kg_m3()) &&
      far_from(merged.mass_kg().best(), mass.low(), mass.high())) {
    doubts.push_back(remark("mass_kg", merged.mass_kg().best(), "kg", taken_for, mass.low(), mass.high()));
  }
  const double volume = facts.mesh.volume_m3;
  if (written.has_mass_kg() && volume > 0 && merged.fill() == Physics::SOLID && doubts.empty() &&
      (written.mass_kg() < kMinDensity_kg_m3 * volume || written.mass_kg() > kMaxDensity_kg_m3 * volume)) {
    doubts.push_back(remark("mass_kg", written.mass_kg(), "kg", "materials of its volume have",
                            kMinDensity_kg_m3 * volume, kMaxDensity_kg_m3 * volume));
  }
  return doubts;
}

}  // namespace livegs
