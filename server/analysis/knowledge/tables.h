// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "livegs/v1/physics.pb.h"

// Lookup tables of the offline estimator, compiled in from materials.csv and objects.csv in this folder.
//
// Sources in materials.csv: T typical handbook values; S F I M R public tables (see README.md of this room);
// O own judgement. objects.csv is own general knowledge of the materials, usual sizes and masses of everyday
// objects; its values are not fitted to a set of objects.

namespace livegs {

struct Span3 {
  double low = 0, best = 0, high = 0;
};

struct MaterialRow {
  std::string name, material_class;
  Span3 density_kg_m3, youngs_modulus_pa;
  double poisson_ratio, restitution, friction, plasticity, loss_factor;
  bool fragile;
  // Colour of a cut through it, 0 to 1, display-encoded, for materials that are often glazed, painted or
  // coated; nothing if the inside looks like the surface.
  std::optional<std::array<double, 3>> inside_rgb;
};

// Another meaning of a name: an enamel mug for "mug".
struct ObjectAlternative {
  std::string label;  // of another row
  double probability = 0;
};

// Where a part of an object usually is. Vertical places hold for a thing that stands.
enum class PartPlace {
  Unknown,  // "-": no usual place
  Above,    // the upper part
  Below,    // the lower part
  Wide,     // the end of the long axis with the wider cross-section
  Thin,     // the end of the long axis with the thinner cross-section
  Rest,     // all that the other parts leave
  Inside,   // within the first part of the row, and hidden by it: the bulb of a lamp
  Filling,  // fills the first part of the row, which is open above: soil in a pot
};

// A part of an object of several materials.
struct ObjectPart {
  std::string name, material;
  double mass_share = 0;
  PartPlace place = PartPlace::Unknown;
};

struct ObjectRow {
  std::string label;
  std::vector<std::string> names;  // the label and its aliases, lower case
  std::string category;            // kitchen, package, fruit, tool, …
  std::string material;            // name of a MaterialRow
  v1::Physics::Fill fill;
  Span3 wall_m, size_m;      // of the wall; of the longest side
  double middle_m, short_m;  // other two sides of the smallest box of a typical one
  double box_filling;        // fraction of that box that it fills, 0 … 1: ball 0.52, can 0.77, carton 0.93
  double mass_kg;            // of a typical one
  double mass_log_sd;        // of ln(mass) among objects of this class and size
  Span3 structure_coefficient;
  std::vector<ObjectAlternative> alternatives;  // the rest of the probability is the row itself
  std::vector<ObjectPart> parts;                // empty for objects of one material
  std::string source;                           // source letters of README.md, never empty
};

// Exponent of mass over edge length for objects of this class. 3 for filled things (food, packages, blocks,
// stones); 2 for shells, frames and machines, whose wall thickness grows little.
double mass_exponent(const ObjectRow& row);

// Parsed once. Aborts if a compiled-in table is malformed (a test reads both).
const std::vector<MaterialRow>& material_table();
const std::vector<ObjectRow>& object_table();
const MaterialRow& material_row(std::string_view name);       // precondition: the name is in the table
const MaterialRow* find_material_row(std::string_view name);  // nullptr if not found
const ObjectRow* find_object_row(std::string_view label);     // by label, not by alias; nullptr if not found

// Sets the colour of cut faces to that of the material, or clears it if the inside looks like the surface.
void set_inside(const MaterialRow& material, v1::PhysicalParameters& parameters);
// Whether the colour of cut faces is that of the material, not one that a scene states.
bool has_inside_of(const MaterialRow& material, const v1::PhysicalParameters& parameters);

// Level of plasticity with reference objects, for judgement by comparison. LIVE-GS's p: 0 springs back, 1
// keeps its shape after a bend or dent. Ascending.
struct PlasticityLevel {
  double plasticity = 0;
  std::string level;  // name in the answer schema; empty for a level between two of the schema
  std::vector<std::string> references;  // "cloth", "rope"

  std::string text() const;  // "felt, cloth, rope"
};
const std::vector<PlasticityLevel>& plasticity_ladder();
// Finds a level by its name or one of its references; nullptr if not found.
const PlasticityLevel* find_plasticity_level(std::string_view word);
const PlasticityLevel& nearest_plasticity_level(double plasticity);

}  // namespace livegs
