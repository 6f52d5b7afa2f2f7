// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/analyze/parameters_table.h"

#include <cstdio>

#include "analysis/division/part_places.h"
#include "analysis/estimate/physics_values.h"

namespace livegs {
namespace {

void print_value(const char* name, const v1::EstimatedValue& value, double factor, const char* unit) {
  std::printf("%-22s %10.4g %-4s %9.4g to %-9.4g %-8s %s\n", name, value.best() * factor, unit,
              value.low() * factor, value.high() * factor, source_name(value.source()),
              value.reason().c_str());
}

}  // namespace

void print_parameters(const v1::PhysicalParameters& p) {
  std::printf("identified as          %s, of %s (confidence %.2f)\n", p.label().c_str(), p.material().c_str(),
              p.confidence());
  std::printf("behaviour              %s: %s\n", v1::Physics::Behavior_Name(p.behavior()).c_str(),
              p.behavior_reason().c_str());
  std::printf("fill                   %s: %s\n", v1::Physics::Fill_Name(p.fill()).c_str(),
              p.fill_reason().c_str());
  std::printf("fragile                %s\n", p.fragile() ? "yes" : "no");
  print_value("longest side", p.longest_side_m(), 1, "m");
  print_value("mass", p.mass_kg(), 1, "kg");
  print_value("wall thickness", p.wall_thickness_m(), 1e3, "mm");
  print_value("Young's modulus", p.youngs_modulus_pa(), 1e-6, "MPa");
  print_value("Poisson ratio", p.poisson_ratio(), 1, "");
  print_value("structure coefficient", p.structure_coefficient(), 1, "");
  print_value("deformation resistance", p.deformation_resistance(), 1, "");
  print_value("plasticity", p.plasticity(), 1, "");
  print_value("damping", p.damping(), 1, "");
  print_value("friction", p.friction(), 1, "");
  print_value("restitution", p.restitution(), 1, "");
  if (p.fragile()) print_value("break impulse", p.break_impulse_n_s(), 1, "N s");
  for (const v1::MaterialPart& part : p.parts())
    std::printf("part                   %s\n", part_line(part).c_str());
  if (p.parts_size() > 0)
    std::printf("parts                  %s: %s\n", source_name(p.parts_source()), p.parts_reason().c_str());
}

void print_table_head() {
  std::printf("%-20s %-18s %-20s %-9s %10s  %-21s %10s %6s %-8s %-8s %s\n", "object", "identified as",
              "material", "behaviour", "mass g", "90 % range", "s E MPa", "d_R", "fragile", "source",
              "confidence");
}

void print_table_row(const std::string& name, const v1::PhysicalParameters& p) {
  char range[48];
  std::snprintf(range, sizeof range, "%.4g to %.4g", p.mass_kg().low() * 1e3, p.mass_kg().high() * 1e3);
  const double stiffness_pa = p.structure_coefficient().best() * p.youngs_modulus_pa().best();
  std::printf("%-20s %-18s %-20s %-9s %10.4g  %-21s %10.3g %6.3f %-8s %-8s %.2f\n", name.c_str(),
              p.label().c_str(), p.material().c_str(), v1::Physics::Behavior_Name(p.behavior()).c_str(),
              p.mass_kg().best() * 1e3, range, stiffness_pa * 1e-6, p.deformation_resistance().best(),
              p.fragile() ? "yes" : "no", source_name(p.mass_kg().source()), p.confidence());
}

}  // namespace livegs
