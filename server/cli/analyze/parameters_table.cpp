// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/analyze/parameters_table.h"

#include "analysis/division/part_places.h"
#include "analysis/estimate/physics_values.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

std::string value_line(const char* name, const v1::EstimatedValue& value, double factor, const char* unit) {
  return format_text("%-22s %10.4g %-4s %9.4g to %-9.4g %-8s %s\n", name, value.best() * factor, unit,
                     value.low() * factor, value.high() * factor, source_name(value.source()),
                     value.reason().c_str());
}

}  // namespace

std::string parameters_text(const v1::PhysicalParameters& p) {
  std::string text;
  text += format_text("identified as          %s, of %s (confidence %.2f)\n", p.label().c_str(),
                      p.material().c_str(), p.confidence());
  text += format_text("behaviour              %s: %s\n", v1::Physics::Behavior_Name(p.behavior()).c_str(),
                      p.behavior_reason().c_str());
  text += format_text("fill                   %s: %s\n", v1::Physics::Fill_Name(p.fill()).c_str(),
                      p.fill_reason().c_str());
  text += format_text("fragile                %s\n", p.fragile() ? "yes" : "no");
  text += value_line("longest side", p.longest_side_m(), 1, "m");
  text += value_line("mass", p.mass_kg(), 1, "kg");
  text += value_line("wall thickness", p.wall_thickness_m(), 1e3, "mm");
  text += value_line("Young's modulus", p.youngs_modulus_pa(), 1e-6, "MPa");
  text += value_line("Poisson ratio", p.poisson_ratio(), 1, "");
  text += value_line("structure coefficient", p.structure_coefficient(), 1, "");
  text += value_line("deformation resistance", p.deformation_resistance(), 1, "");
  text += value_line("plasticity", p.plasticity(), 1, "");
  text += value_line("damping", p.damping(), 1, "");
  text += value_line("friction", p.friction(), 1, "");
  text += value_line("restitution", p.restitution(), 1, "");
  if (p.fragile()) text += value_line("break impulse", p.break_impulse_n_s(), 1, "N s");
  for (const v1::MaterialPart& part : p.parts())
    text += format_text("part                   %s\n", part_line(part).c_str());
  if (p.parts_size() > 0)
    text += format_text("parts                  %s: %s\n", source_name(p.parts_source()),
                        p.parts_reason().c_str());
  return text;
}

std::string table_head() {
  return format_text("%-20s %-18s %-20s %-9s %10s  %-21s %10s %6s %-8s %-8s %s\n", "object", "identified as",
                     "material", "behaviour", "mass g", "90 % range", "s E MPa", "d_R", "fragile", "source",
                     "confidence");
}

std::string table_row(const std::string& name, const v1::PhysicalParameters& p) {
  const std::string range = format_text("%.4g to %.4g", p.mass_kg().low() * 1e3, p.mass_kg().high() * 1e3);
  const double stiffness_pa = p.structure_coefficient().best() * p.youngs_modulus_pa().best();
  return format_text("%-20s %-18s %-20s %-9s %10.4g  %-21s %10.3g %6.3f %-8s %-8s %.2f\n", name.c_str(),
                     p.label().c_str(), p.material().c_str(),
                     v1::Physics::Behavior_Name(p.behavior()).c_str(), p.mass_kg().best() * 1e3,
                     range.c_str(), stiffness_pa * 1e-6, p.deformation_resistance().best(),
                     p.fragile() ? "yes" : "no", source_name(p.mass_kg().source()), p.confidence());
}

}  // namespace livegs
