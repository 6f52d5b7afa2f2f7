// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/knowledge/tables.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/assert.h"
#include "materials.csv.h"
#include "objects.csv.h"
#include "plasticity.csv.h"

namespace livegs {
namespace {

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> parts;
  for (size_t begin = 0;;) {
    const size_t end = text.find(separator, begin);
    parts.emplace_back(text.substr(begin, end == std::string_view::npos ? end : end - begin));
    if (end == std::string_view::npos) return parts;
    begin = end + 1;
  }
}

// Splits a CSV without quoting into rows, without the header. Every row has `columns` cells.
std::vector<std::vector<std::string>> rows_of(std::string_view csv, size_t columns) {
  std::vector<std::vector<std::string>> rows;
  bool header = true;
  for (const std::string& line : split(csv, '\n')) {
    if (line.empty()) continue;
    if (!header) {
      rows.push_back(split(line, ','));
      LIVEGS_ASSERT(rows.back().size() == columns);
    }
    header = false;
  }
  return rows;
}

double number(const std::string& cell) {
  char* end = nullptr;
  const double value = std::strtod(cell.c_str(), &end);
  LIVEGS_ASSERT(!cell.empty() && *end == '\0');
  return value;
}

Span3 span(const std::vector<std::string>& row, size_t at, double factor = 1.0) {
  return {number(row[at]) * factor, number(row[at + 1]) * factor, number(row[at + 2]) * factor};
}

// Parses "C6B294"; nothing for an empty cell.
std::optional<std::array<double, 3>> colour(const std::string& cell) {
  if (cell.empty()) return std::nullopt;
  char* end = nullptr;
  const unsigned long rgb = std::strtoul(cell.c_str(), &end, 16);
  LIVEGS_ASSERT(cell.size() == 6 && *end == '\0');
  const auto part = [&](int shift) { return static_cast<double>(rgb >> shift & 255) / 255; };
  return std::array{part(16), part(8), part(0)};
}

std::vector<MaterialRow> parse_materials() {
  std::vector<MaterialRow> table;
  for (const auto& row : rows_of(kMaterialsCsv, 16)) {
    table.push_back({row[0], row[1], span(row, 2), span(row, 5), number(row[8]), number(row[9]),
                     number(row[10]), number(row[12]), number(row[13]), row[11] == "1", colour(row[14])});
  }
  return table;
}

// Splits "a:0.2|b:0.1" into the cells a and 0.2, b and 0.1.
std::vector<std::vector<std::string>> pieces_of(const std::string& cell, size_t columns) {
  std::vector<std::vector<std::string>> pieces;
  for (const std::string& piece : split(cell, '|')) {
    if (piece.empty()) continue;
    pieces.push_back(split(piece, ':'));
    LIVEGS_ASSERT(pieces.back().size() == columns);
  }
  return pieces;
}

PartPlace part_place(std::string_view word) {
  constexpr std::pair<std::string_view, PartPlace> kWords[] = {
      {"-", PartPlace::Unknown},     {"above", PartPlace::Above},    {"below", PartPlace::Below},
      {"wide", PartPlace::Wide},     {"thin", PartPlace::Thin},      {"rest", PartPlace::Rest},
      {"inside", PartPlace::Inside}, {"filling", PartPlace::Filling}};
  const auto found =
      std::find_if(std::begin(kWords), std::end(kWords), [&](const auto& one) { return one.first == word; });
  LIVEGS_ASSERT(found != std::end(kWords));
  return found->second;
}

std::vector<ObjectRow> parse_objects() {
  std::vector<ObjectRow> table;
  for (const auto& row : rows_of(kObjectsCsv, 22)) {
    ObjectRow object;
    object.label = row[0];
    object.names = {row[0]};
    for (std::string& alias : split(row[1], '|')) {
      if (!alias.empty()) object.names.push_back(std::move(alias));
    }
    object.category = row[2];
    object.material = row[3];
    LIVEGS_ASSERT(v1::Physics::Fill_Parse(row[4], &object.fill));
    object.wall_m = span(row, 5, 1e-3);
    object.size_m = span(row, 8);
    object.middle_m = number(row[11]);
    object.short_m = number(row[12]);
    object.box_filling = number(row[13]);
    object.mass_kg = number(row[14]);
    object.mass_log_sd = number(row[15]);
    object.structure_coefficient = span(row, 16);
    for (const auto& piece : pieces_of(row[19], 2)) {
      object.alternatives.push_back({piece[0], number(piece[1])});
    }
    for (const auto& piece : pieces_of(row[20], 4)) {
      object.parts.push_back({piece[0], piece[1], number(piece[2]), part_place(piece[3])});
    }
    object.source = row[21];
    table.push_back(std::move(object));
  }
  return table;
}

std::vector<PlasticityLevel> parse_ladder() {
  std::vector<PlasticityLevel> ladder;
  for (const auto& row : rows_of(kPlasticityCsv, 3))
    ladder.push_back({number(row[0]), row[1], split(row[2], '|')});
  LIVEGS_ASSERT(!ladder.empty());
  return ladder;
}

}  // namespace

const std::vector<MaterialRow>& material_table() {
  static const std::vector<MaterialRow> table = parse_materials();
  return table;
}

const std::vector<ObjectRow>& object_table() {
  static const std::vector<ObjectRow> table = parse_objects();
  return table;
}

const MaterialRow* find_material_row(std::string_view name) {
  for (const MaterialRow& row : material_table()) {
    if (row.name == name) return &row;
  }
  return nullptr;
}

const MaterialRow& material_row(std::string_view name) {
  const MaterialRow* row = find_material_row(name);
  LIVEGS_ASSERT(row && "a material that is not in the table");
  return *row;
}

const ObjectRow* find_object_row(std::string_view label) {
  for (const ObjectRow& row : object_table()) {
    if (row.label == label) return &row;
  }
  return nullptr;
}

void set_inside(const MaterialRow& material, v1::PhysicalParameters& parameters) {
  parameters.clear_interior_rgb();
  if (!material.inside_rgb) return;
  for (const double part : *material.inside_rgb) parameters.add_interior_rgb(part);
}

bool has_inside_of(const MaterialRow& material, const v1::PhysicalParameters& parameters) {
  const auto& rgb = parameters.interior_rgb();
  if (!material.inside_rgb) return rgb.empty();
  return std::equal(rgb.begin(), rgb.end(), material.inside_rgb->begin(), material.inside_rgb->end());
}

double mass_exponent(const ObjectRow& row) {
  for (const char* full : {"package", "fruit", "food", "block", "living", "statues", "books"}) {
    if (row.category == full && row.fill != v1::Physics::SHELL && row.fill != v1::Physics::OPEN_SHELL)
      return 3;
  }
  return 2;
}

const std::vector<PlasticityLevel>& plasticity_ladder() {
  static const std::vector<PlasticityLevel> ladder = parse_ladder();
  return ladder;
}

std::string PlasticityLevel::text() const {
  std::string all = level == "none" ? "" : level;
  for (const std::string& reference : references) all += (all.empty() ? "" : ", ") + reference;
  return all;
}

const PlasticityLevel* find_plasticity_level(std::string_view word) {
  for (const PlasticityLevel& one : plasticity_ladder()) {
    if (!word.empty() && (one.level == word || std::find(one.references.begin(), one.references.end(),
                                                         word) != one.references.end())) {
      return &one;
    }
  }
  return nullptr;
}

const PlasticityLevel& nearest_plasticity_level(double plasticity) {
  const PlasticityLevel* nearest = &plasticity_ladder().front();
  for (const PlasticityLevel& level : plasticity_ladder()) {
    if (std::abs(level.plasticity - plasticity) < std::abs(nearest->plasticity - plasticity))
      nearest = &level;
  }
  return *nearest;
}

}  // namespace livegs
