// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/tool_box.h"

#include <algorithm>
#include <cmath>

#include "analysis/estimate/physics_values.h"
#include "analysis/knowledge/table_search.h"
#include "analysis/text/json_text.h"
#include "analysis/text/prompt_text.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

constexpr std::size_t kMaxArgumentLength = 16 << 10, kMaxResultLength = 4 << 10;
constexpr std::size_t kMaxParts = 32, kMaxHits = 8;
constexpr double kMaxPartDensity_kg_m3 = 23000;

using ToolAnswer = OrderedJson;

// Rounds to four digits: the precision of a table range, and short.
double rounded(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return std::strtod(text, nullptr);
}

ToolAnswer range(double low, double best, double high, double factor = 1.0) {
  return {{"low", rounded(low * factor)}, {"best", rounded(best * factor)}, {"high", rounded(high * factor)}};
}
ToolAnswer range(const Span3& span, double factor = 1.0) {
  return range(span.low, span.best, span.high, factor);
}

ToolAnswer describe(const KnowledgeHit& hit) {
  if (hit.material) {
    const MaterialRow& row = *hit.material;
    return {{"id", hit.id},
            {"class", row.material_class},
            {"density_kg_m3", range(row.density_kg_m3)},
            {"young_mpa", range(row.youngs_modulus_pa, 1e-6)},
            {"plasticity", row.plasticity},
            {"friction", row.friction},
            {"restitution", row.restitution},
            {"fragile", row.fragile}};
  }
  const ObjectRow& row = *hit.object;
  return {{"id", hit.id},
          {"material_id", row.material},
          {"fill", fill_name(row.fill)},
          {"wall_mm", range(row.wall_m, 1e3)},
          {"longest_side_m", range(row.size_m)},
          {"structure_s", range(row.structure_coefficient)}};
}

// Arguments of one call, read with guards; the first error is kept for the result.
class Arguments {
 public:
  Arguments(const Json& object, const MessageTemplates& words) : object_(object), words_(words) {}

  // Reads a number in low … high; accepts a number written as text, as small models do.
  double number(const char* name, double low, double high) {
    const std::optional<double> value = optional_number(name, low, high);
    if (!value) wrong("number_needed", {{"argument", name}});
    return value.value_or(low);
  }
  std::optional<double> optional_number(const char* name, double low, double high) {
    const Json* value = member(object_, name);
    if (!value || value->is_null()) return std::nullopt;
    double read = NAN;
    if (value->is_number()) read = value->get<double>();
    if (value->is_string()) {
      const std::string text = value->get<std::string>();
      char* end = nullptr;
      read = std::strtod(text.c_str(), &end);
      if (end == text.c_str() || *end != '\0') read = NAN;
    }
    if (std::isfinite(read) && read >= low && read <= high) return read;
    wrong("number_outside",
          {{"argument", name}, {"low", format_text("%g", low)}, {"high", format_text("%g", high)}});
    return std::nullopt;
  }
  std::string text(const char* name) {
    const std::string value = text_member(object_, name);
    if (value.empty()) wrong("text_needed", {{"argument", name}});
    return value.substr(0, 200);
  }
  const Json* array(const char* name) {
    const Json* value = member(object_, name);
    if (value && value->is_array()) return value;
    wrong("array_needed", {{"argument", name}});
    return nullptr;
  }
  // Stores the error as a line of prompts/tool_words.json.
  void wrong(std::string_view line,
             std::initializer_list<std::pair<std::string_view, std::string_view>> slots = {}) {
    if (error_.empty()) error_ = words_.say(line, slots);
  }
  const std::string& error() const { return error_; }

 private:
  const Json& object_;
  const MessageTemplates& words_;
  std::string error_;
};

ToolAnswer material_search(const ToolBox&, Arguments& in) {
  const std::string query = in.text("query");
  const double count = in.optional_number("k", 1, kMaxHits).value_or(3);
  ToolAnswer hits = ToolAnswer::array();
  for (const KnowledgeHit& hit : search_knowledge(query, static_cast<std::size_t>(count))) {
    hits.push_back(describe(hit));
  }
  return {{"hits", hits}};
}

ToolAnswer kb_get(const ToolBox&, Arguments& in) {
  const KnowledgeHit hit = find_knowledge(in.text("id"));
  if (!hit.material && !hit.object) {
    in.wrong("no_row");
    return {};
  }
  return describe(hit);
}

ToolAnswer mass_from_parts(const ToolBox& box, Arguments& in) {
  const Json* parts = in.array("parts");
  if (!parts) return {};
  if (parts->empty() || parts->size() > kMaxParts) {
    in.wrong("part_count", {{"most", std::to_string(kMaxParts)}});
    return {};
  }
  ToolAnswer list = ToolAnswer::array();
  Span3 total;
  for (std::size_t i = 0; i < parts->size(); ++i) {
    Arguments part((*parts)[i], box.words());
    const KnowledgeHit hit = find_knowledge(part.text("material_id"));
    if (!hit.material) part.wrong("no_material");
    const std::optional<double> volume_cm3 = part.optional_number("volume_cm3", 0, 1e9);
    const std::optional<double> area_cm2 = part.optional_number("area_cm2", 0, 1e7);
    const std::optional<double> thickness_mm = part.optional_number("thickness_mm", 0, 1e4);
    if (!volume_cm3 && !(area_cm2 && thickness_mm)) part.wrong("part_no_volume");
    if (!part.error().empty()) {
      in.wrong("part_wrong", {{"index", std::to_string(i)}, {"problem", part.error()}});
      return {};
    }
    const double volume_m3 = volume_cm3 ? *volume_cm3 * 1e-6 : *area_cm2 * 1e-4 * *thickness_mm * 1e-3;
    const Span3& density = hit.material->density_kg_m3;
    const Span3 mass_kg{density.low * volume_m3, density.best * volume_m3, density.high * volume_m3};
    total = {total.low + mass_kg.low, total.best + mass_kg.best, total.high + mass_kg.high};
    list.push_back({{"material_id", hit.material->name}, {"mass_g", range(mass_kg, 1e3)}});
  }
  return {{"mass_g", range(total, 1e3)}, {"parts", list}};
}

ToolAnswer shell_mass(const ToolBox&, Arguments& in) {
  const double area_m2 = in.number("area_m2", 0, 1e4);
  const double thickness_mm = in.number("thickness_mm", 0, 1e4);
  const double density_kg_m3 = in.number("density_kg_m3", 1, kMaxPartDensity_kg_m3);
  return {{"mass_g", rounded(area_m2 * thickness_mm * 1e-3 * density_kg_m3 * 1e3)}};
}

// --- the one place where a tool is declared
// ---------------------------------------------------------------------

enum class ValueKind { Number, OptionalNumber, Text, Parts };
struct Parameter {
  const char* name;
  ValueKind kind;
};
struct Tool {
  const char* name;
  std::vector<Parameter> parameters;
  ToolAnswer (*function)(const ToolBox&, Arguments&);
};

const std::vector<Tool>& tools() {
  static const std::vector<Tool> all = {
      {"material_search", {{"query", ValueKind::Text}, {"k", ValueKind::OptionalNumber}}, material_search},
      {"kb_get", {{"id", ValueKind::Text}}, kb_get},
      {"mass_from_parts", {{"parts", ValueKind::Parts}}, mass_from_parts},
      {"shell_mass",
       {{"area_m2", ValueKind::Number},
        {"thickness_mm", ValueKind::Number},
        {"density_kg_m3", ValueKind::Number}},
       shell_mass}};
  return all;
}

OrderedJson schema_of(const std::vector<Parameter>& parameters) {
  OrderedJson properties = OrderedJson::object(), required = OrderedJson::array();
  for (const Parameter& parameter : parameters) {
    required.push_back(parameter.name);
    switch (parameter.kind) {
      case ValueKind::Number:
        properties[parameter.name] = {{"type", "number"}};
        break;
      case ValueKind::OptionalNumber:
        properties[parameter.name] = {{"type", {"number", "null"}}};
        break;
      case ValueKind::Text:
        properties[parameter.name] = {{"type", "string"}};
        break;
      case ValueKind::Parts:
        properties[parameter.name] = {{"type", "array"},
                                      {"items", schema_of({{"material_id", ValueKind::Text},
                                                           {"volume_cm3", ValueKind::OptionalNumber},
                                                           {"area_cm2", ValueKind::OptionalNumber},
                                                           {"thickness_mm", ValueKind::OptionalNumber}})}};
        break;
    }
  }
  return {{"type", "object"},
          {"properties", properties},
          {"required", required},
          {"additionalProperties", false}};
}

std::string error_text(const std::string& what) { return dump_json(OrderedJson{{"error", what}}); }

}  // namespace

ToolBox::ToolBox(ObjectFacts object, std::vector<SceneObjectFacts> scene, const MessageTemplates& words)
    : object_(std::move(object)), scene_(std::move(scene)), words_(&words) {}

const std::vector<ToolDescriptor>& ToolBox::descriptors() {
  static const std::vector<ToolDescriptor> all = [] {
    std::vector<ToolDescriptor> list;
    for (const Tool& tool : tools()) list.push_back({tool.name, dump_json(schema_of(tool.parameters))});
    return list;
  }();
  return all;
}

std::string ToolBox::call(std::string_view name, std::string_view arguments) const {
  const auto tool =
      std::find_if(tools().begin(), tools().end(), [&](const Tool& one) { return one.name == name; });
  if (tool == tools().end()) {
    std::string known;
    for (const Tool& one : tools()) known += (known.empty() ? "" : ", ") + std::string(one.name);
    return error_text(words_->say("no_tool", {{"tools", known}}));
  }
  if (arguments.size() > kMaxArgumentLength) return error_text(words_->say("arguments_too_long"));
  Result<Json> parsed = arguments.empty() ? Result<Json>(Json::object()) : parse_json(arguments);
  if (parsed && parsed->is_null()) parsed = Json::object();
  // Some servers encode the object as a JSON string.
  if (parsed && parsed->is_string()) parsed = parse_json(parsed->get<std::string>());
  if (!parsed || !parsed->is_object()) return error_text(words_->say("arguments_no_object"));
  Arguments in(*parsed, *words_);
  const ToolAnswer answer = tool->function(*this, in);
  if (!in.error().empty()) return error_text(in.error());
  std::string result = dump_json(answer);
  if (result.size() > kMaxResultLength) return error_text(words_->say("result_too_long"));
  return result;
}

}  // namespace livegs
