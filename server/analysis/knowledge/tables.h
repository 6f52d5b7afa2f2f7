// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "livegs/v1/physics.pb.h"

// The tables the offline estimator looks things up in: materials.csv and objects.csv beside this file,
// compiled in. Sources of materials.csv: T handbook typical values, S F I M R public tables (see README.md of
// this room), O our own judgement. objects.csv is our own general knowledge: what everyday things are made
// of, how large they usually are and what they weigh; nothing in it was fitted to a set of objects.

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

// Another thing that a name may mean: an enamel mug for "mug".
struct ObjectAlternative {
  std::string label;  // of another row
  double probability = 0;
};

// A part of a thing of several materials.
struct ObjectPart {
  std::string name, material;
  double mass_share = 0;
};

struct ObjectRow {
  std::string label;
  std::vector<std::string> names;  // the label and its aliases, lower case
  std::string category;            // kitchen, package, fruit, tool, …
  std::string material;            // a MaterialRow's name
  v1::Physics::Fill fill;
  Span3 wall_m, size_m;      // of the wall; of the longest side
  double middle_m, short_m;  // the other two sides of a usual one's smallest box
  double box_filling;        // how much of that box it fills, 0 … 1: a ball 0.52, a can 0.77, a carton 0.93
  double mass_kg;            // of a usual one
  double mass_log_sd;        // of ln(mass) among things of this kind and size
  Span3 structure_coefficient;
  std::vector<ObjectAlternative> alternatives;  // the rest of the probability is the row's own
  std::vector<ObjectPart> parts;                // empty for things of one material
  std::string source;                           // letters of README.md, never empty
};

// How mass grows with the edge of a thing of this kind: 3 for what is full (food, packages, blocks, stones),
// 2 for shells, frames and machines, whose walls grow little (within categories of furniture and household
// goods the measured exponent is 1.8: analysis.md 5.2).
double mass_exponent(const ObjectRow& row);

// Parsed once; aborts if a table that was compiled in is malformed (a test reads both).
const std::vector<MaterialRow>& material_table();
const std::vector<ObjectRow>& object_table();
const MaterialRow& material_row(std::string_view name);       // precondition: the name is in the table
const MaterialRow* find_material_row(std::string_view name);  // nullptr for another name
const ObjectRow* find_object_row(std::string_view label);  // by label, not by alias; nullptr for another one

// What a thing does with a bend or a dent, by comparison: each level of plasticity (LIVE-GS's p, 0 springs
// back, 1 stays) with things that have it. Ascending.
struct PlasticityLevel {
  double plasticity = 0;
  std::string level;                    // what the answer's schema calls it; empty: between two that it has
  std::vector<std::string> references;  // "cloth", "rope"

  std::string text() const;  // "felt, cloth, rope"
};
const std::vector<PlasticityLevel>& plasticity_ladder();
// By a level's name or one of its references; nullptr for another word.
const PlasticityLevel* find_plasticity_level(std::string_view word);
const PlasticityLevel& nearest_plasticity_level(double plasticity);

}  // namespace livegs
