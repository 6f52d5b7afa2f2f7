// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/knowledge.h"

#include <cstdlib>

#include "core/assert.h"
#include "materials.csv.h"
#include "objects.csv.h"

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

// Rows of a CSV without quoting, header left out; every row has `columns` cells.
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

std::vector<MaterialRow> parse_materials() {
  std::vector<MaterialRow> table;
  for (const auto& row : rows_of(kMaterialsCsv, 15)) {
    table.push_back({row[0], row[1], span(row, 2), span(row, 5), number(row[8]), number(row[9]),
                     number(row[10]), number(row[12]), number(row[13]), row[11] == "1"});
  }
  return table;
}

std::vector<ObjectRow> parse_objects() {
  std::vector<ObjectRow> table;
  for (const auto& row : rows_of(kObjectsCsv, 13)) {
    ObjectRow object;
    object.label = row[0];
    object.names = {row[0]};
    for (std::string& alias : split(row[1], '|')) {
      if (!alias.empty()) object.names.push_back(std::move(alias));
    }
    object.material = row[2];
    LIVEGS_ASSERT(v1::Physics::Fill_Parse(row[3], &object.fill));
    object.wall_m = span(row, 4, 1e-3);
    object.size_m = span(row, 7);
    object.structure_coefficient = span(row, 10);
    table.push_back(std::move(object));
  }
  return table;
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

}  // namespace livegs
