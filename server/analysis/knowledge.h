// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "livegs/v1/physics.pb.h"

// The tables the offline estimator looks things up in: materials.csv and objects.csv beside this file,
// compiled in. Sources of materials.csv: T handbook typical values, S F I M R public tables (see README.md of
// this room), Y known masses, O our own judgement. objects.csv is our own: what everyday things are made of
// and how large they usually are.

namespace livegs {

struct Span3 {
  double low = 0, best = 0, high = 0;
};

struct MaterialRow {
  std::string name, material_class;
  Span3 density_kg_m3, youngs_modulus_pa;
  double poisson_ratio, restitution, friction, plasticity, loss_factor;
  bool fragile;
};

struct ObjectRow {
  std::string label;
  std::vector<std::string> names;  // the label and its aliases, lower case
  std::string material;            // a MaterialRow's name
  v1::Physics::Fill fill;
  Span3 wall_m, size_m, structure_coefficient;
};

// Parsed once; aborts if a table that was compiled in is malformed (a test reads both).
const std::vector<MaterialRow>& material_table();
const std::vector<ObjectRow>& object_table();
const MaterialRow& material_row(std::string_view name);  // precondition: the name is in the table
const MaterialRow* find_material_row(std::string_view name);  // nullptr for another name

}  // namespace livegs
