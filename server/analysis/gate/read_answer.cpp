// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <charconv>
#include <cmath>

#include "analysis/gate/answer.h"
#include "analysis/gate/answer_object.h"
#include "analysis/gate/answer_parts.h"
#include "analysis/knowledge/name_match.h"
#include "analysis/knowledge/table_search.h"
#include "analysis/knowledge/tables.h"
#include "analysis/text/prompt_text.h"
#include "core/text/shown_text.h"

// Step 2 of the gate (gate.h): types, words, order, hard ranges; step 1 is answer_object(). The first error
// ends the reading and refuses the answer; unusual values are corrected and noted. run/ask_model.cpp then
// sends the error to the model.

namespace livegs {
namespace {

using nlohmann::json;
using v1::Physics;

constexpr const char* kKnownFields[] = {"schema",          "description",      "evidence",   "name",
                                        "name_confidence", "is_replica",       "fill",       "parts",
                                        "behaviour",       "size_m",           "mass_g",     "young_mpa",
                                        "structure_s",     "plasticity_level", "plasticity", "fragile",
                                        "friction",        "restitution",      "confidence", "kb_ids",
                                        "behavior",        "alternatives"};

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

class Reader {
 public:
  Reader(const json& object, const MessageTemplates& words) : object_(object), words_(words) {}

  // The readers below return nothing and store the first error if a field is invalid.
  const json* find(const char* field) const {
    const auto found = object_.find(field);
    return found == object_.end() || found->is_null() ? nullptr : &*found;
  }
  const json* require(const char* field, const char* form) {
    const json* value = find(field);
    if (!value) fail("missing", {{"field", field}, {"form", words_.say(form)}});
    return value;
  }
  std::optional<double> number(const json& value, const std::string& field, ValueRange range,
                               double factor = 1) {
    double number = 0;
    if (value.is_number()) {
      number = value.get<double>();
    } else if (value.is_string()) {
      const auto& text = value.get_ref<const std::string&>();
      const auto parsed = std::from_chars(text.data(), text.data() + text.size(), number);
      if (text.empty() || parsed.ec != std::errc() || parsed.ptr != text.data() + text.size()) {
        return fail("text_for_number", {{"field", field}}), std::nullopt;
      }
      answer.changes.push_back(field + ": the text \"" + shown_text(text, 24) + "\" was read as a number");
    } else {
      return other_type(value, field, "form_number"), std::nullopt;
    }
    if (!std::isfinite(number)) return fail("not_finite", {{"field", field}}), std::nullopt;
    if (!range.holds(number * factor)) {
      return fail("outside", {{"field", field},
                              {"told", number_text(number)},
                              {"low", number_text(range.low / factor)},
                              {"high", number_text(range.high / factor)},
                              {"unit", unit_of(field)}}),
             std::nullopt;
    }
    return number * factor;
  }
  std::optional<double> optional_number(const char* field, ValueRange range) {
    const json* value = find(field);
    return value && !failed() ? number(*value, field, range) : std::nullopt;
  }
  // {low, best, high}; a bare number is used for all three.
  std::optional<Span3> span(const json& value, const std::string& field, ValueRange range, double factor) {
    if (value.is_number()) {
      const auto one = number(value, field, range, factor);
      if (!one) return std::nullopt;
      answer.changes.push_back(field + ": a single number was read as its best value, without a range");
      return Span3{*one, *one, *one};
    }
    if (!value.is_object()) return other_type(value, field, "form_range"), std::nullopt;
    double numbers[3] = {};
    constexpr const char* kNames[] = {"low", "best", "high"};
    for (int i = 0; i < 3; ++i) {
      const auto found = value.find(kNames[i]);
      const std::string member = field + "." + kNames[i];
      if (found == value.end())
        return fail("missing", {{"field", member}, {"form", words_.say("form_number")}}), std::nullopt;
      const auto one = number(*found, member, range, factor);
      if (!one) return std::nullopt;
      numbers[i] = *one;
    }
    if (!(numbers[0] <= numbers[1] && numbers[1] <= numbers[2])) {
      const std::string unit = unit_of(field);
      return fail("out_of_order", {{"field", field},
                                   {"in_unit", unit.empty() ? "" : words_.say("in_unit", {{"unit", unit}})}}),
             std::nullopt;
    }
    if (numbers[2] > kMaxRangeRatio * numbers[0]) {
      return fail("too_wide", {{"field", field}, {"most", number_text(kMaxRangeRatio)}}), std::nullopt;
    }
    return Span3{numbers[0], numbers[1], numbers[2]};
  }
  std::string text(const char* field, size_t characters) const {
    const json* value = find(field);
    return value && value->is_string() ? shown_text(value->get_ref<const std::string&>(), characters) : "";
  }
  std::optional<bool> boolean(const char* field) {
    const json* value = find(field);
    if (!value || failed()) return std::nullopt;
    if (!value->is_boolean()) return fail("no_boolean", {{"field", field}}), std::nullopt;
    return value->get<bool>();
  }

  void fill() {
    const json* value = require("fill", "form_fill");
    if (!value || failed()) return;
    const std::string word = value->is_string() ? value->get<std::string>() : "";
    if (word == "solid")
      answer.fill = Physics::SOLID;
    else if (word == "shell")
      answer.fill = Physics::SHELL;
    else if (word == "open_shell")
      answer.fill = Physics::OPEN_SHELL;
    else if (word == "filled")
      answer.fill = Physics::FILLED;
    else if (word != "assembly")
      fail("fill_word");
  }
  void behaviour() {
    const json* value = find("behavior") ? find("behavior") : require("behaviour", "form_behaviour");
    if (!value || failed()) return;
    const std::string word = value->is_string() ? value->get<std::string>() : "";
    if (word == "rigid")
      answer.behavior = Physics::RIGID;
    else if (word == "elastic")
      answer.behavior = Physics::ELASTIC;
    else
      fail("behaviour_word");
  }
  void parts() {
    const json* value = require("parts", "form_parts");
    if (!value || failed()) return;
    if (!value->is_array() || value->empty()) return fail("parts_none");
    if (value->size() > kMaxListedParts) return fail("parts_many");
    double sum = 0;
    for (size_t i = 0; i < value->size() && !failed(); ++i) {
      part((*value)[i], "parts[" + std::to_string(i) + "]");
      if (!failed()) sum += answer.parts.back().share;
    }
    if (failed()) return;
    if (!(sum > 0)) return fail("parts_no_share");
    if (std::abs(sum - 1) > 0.02) {
      answer.changes.push_back("parts: the shares added up to " + number_text(sum) + " and were scaled to 1");
    }
    for (AnswerPart& part : answer.parts) part.share /= sum;
    join_equal_parts(answer.parts, answer.changes);
    std::stable_sort(answer.parts.begin(), answer.parts.end(),
                     [](const AnswerPart& a, const AnswerPart& b) { return a.share > b.share; });
    limit_parts(answer.parts, kMaxAnswerParts, answer.changes);
  }
  void part(const json& value, const std::string& field) {
    if (!value.is_object()) return fail("part_form", {{"field", field}});
    AnswerPart part;
    const auto name = value.find("name");
    if (name != value.end() && name->is_string())
      part.name = shown_text(name->get_ref<const std::string&>(), 40);
    const auto id = value.find("material_id");
    if (id == value.end() || !id->is_string()) return fail("part_material", {{"field", field}});
    const auto& material = id->get_ref<const std::string&>();
    part.material = find_material_row(material);
    if (!part.material && material.size() <= 64) {
      part.material = match_material(shown_text(material, 64)).row;
      if (part.material) {
        answer.changes.push_back(field + ".material_id: \"" + shown_text(material, 40) + "\" was read as " +
                                 part.material->name);
      }
    }
    if (!part.material) return fail("part_unknown", {{"field", field}, {"told", line_text(material, 40)}});
    const auto share = value.find("share");
    if (share == value.end() || share->is_null()) {
      part.share = 1;
    } else if (const auto number = this->number(*share, field + ".share", kUnitRange)) {
      part.share = *number;
    }
    const auto thickness = value.find("thickness_mm");
    if (!failed() && thickness != value.end() && !thickness->is_null()) {
      // A solid part may have thickness 0.
      if (thickness->is_number() && thickness->get<double>() == 0) {
        answer.changes.push_back(field + ".thickness_mm: 0 was ignored");
      } else {
        part.thickness_m = number(*thickness, field + ".thickness_mm", kWallRange_m, 1e-3);
      }
    }
    const auto inside = value.find("inside");
    if (inside != value.end() && inside->is_string())
      part.inside = shown_text(inside->get_ref<const std::string&>(), 40);
    if (const auto boxes = value.find("boxes"); boxes != value.end() && !boxes->is_null())
      picture_boxes(*boxes, field, part);
    if (!failed()) answer.parts.push_back(std::move(part));
  }
  // A list of [picture, left, top, right, bottom]. Boxes divide the object but change none of its values, so
  // faulty ones are ignored.
  void picture_boxes(const json& value, const std::string& field, AnswerPart& part) {
    constexpr double kThousandths = 1000;
    size_t ignored = 0;
    for (size_t i = 0; value.is_array() && i < std::min(value.size(), 4 * kMaxAnswerBoxes); ++i) {
      const json& one = value[i];
      double numbers[5] = {};
      bool sound = one.is_array() && one.size() == 5 && part.boxes.size() < kMaxAnswerBoxes;
      for (size_t k = 0; sound && k < 5; ++k) {
        sound = one[k].is_number();
        if (sound) numbers[k] = one[k].get<double>();
        sound = sound && numbers[k] >= 0 && numbers[k] <= kThousandths;
      }
      sound =
          sound && (numbers[0] == 1 || numbers[0] == 2) && numbers[1] < numbers[3] && numbers[2] < numbers[4];
      if (!sound) {
        ++ignored;
        continue;
      }
      part.boxes.push_back({static_cast<size_t>(numbers[0]) - 1, numbers[1] / kThousandths,
                            numbers[2] / kThousandths, numbers[3] / kThousandths, numbers[4] / kThousandths});
    }
    if (!value.is_array() || ignored > 0) {
      answer.changes.push_back(field + ".boxes: " + (ignored > 0 ? std::to_string(ignored) + " " : "") +
                               "not [picture, left, top, right, bottom] within the picture, ignored");
    }
  }
  void plasticity() {
    answer.plasticity = optional_number("plasticity", kUnitRange);
    const json* level = find("plasticity_level");
    if (answer.plasticity || !level || failed()) return;
    if (level->is_number()) {
      answer.plasticity = number(*level, "plasticity_level", kUnitRange);
    } else if (level->is_string()) {
      if (const auto* one = find_plasticity_level(level->get_ref<const std::string&>()))
        answer.plasticity = one->plasticity;
    }
    if (!answer.plasticity && !failed())
      answer.changes.push_back("plasticity_level: not a level of the scale, ignored");
  }
  // A list of {name, probability, mass_g}. Probabilities are scaled to 1. The mass of the answer becomes that
  // of the most probable one.
  void alternatives() {
    const json* value = find("alternatives");
    if (!value || failed()) return;
    if (!value->is_array() || value->size() > kMaxAlternatives)
      return fail("alternatives_form", {{"most", std::to_string(kMaxAlternatives)}});
    double sum = 0;
    for (size_t i = 0; i < value->size() && !failed(); ++i) {
      const json& one = (*value)[i];
      const std::string field = "alternatives[" + std::to_string(i) + "]";
      if (!one.is_object() || !one.contains("probability") || !one.contains("mass_g"))
        return fail("alternatives_form", {{"most", std::to_string(kMaxAlternatives)}});
      MassAlternative read;
      const auto name = one.find("name");
      if (name != one.end() && name->is_string())
        read.name = shown_text(name->get_ref<const std::string&>(), 80);
      read.probability = number(one["probability"], field + ".probability", kUnitRange).value_or(0);
      if (!failed())
        read.mass_kg = span(one["mass_g"], field + ".mass_g", kMassRange_kg, 1e-3).value_or(Span3{});
      sum += read.probability;
      if (read.probability > 0) answer.alternatives.push_back(std::move(read));
    }
    if (failed()) return;
    for (MassAlternative& one : answer.alternatives) one.probability /= sum;
    std::stable_sort(
        answer.alternatives.begin(), answer.alternatives.end(),
        [](const MassAlternative& a, const MassAlternative& b) { return a.probability > b.probability; });
    if (answer.alternatives.empty()) return;
    answer.mass_kg = answer.alternatives.front().mass_kg;
    if (!answer.alternatives.front().name.empty()) answer.name = answer.alternatives.front().name;
    if (answer.alternatives.size() == 1) answer.alternatives.clear();
  }
  // The next four fields affect no value: invalid ones are ignored and the answer stays valid.
  void size() {
    const json* value = find("size_m");
    if (!value || failed()) return;
    double longest = 0;
    bool sound = value->is_array() && value->size() == 3;
    for (size_t i = 0; sound && i < 3; ++i) {
      const json& side = (*value)[i];
      sound = side.is_number() && kSizeRange_m.holds(side.get<double>());
      if (sound) longest = std::max(longest, side.get<double>());
    }
    if (sound) {
      answer.longest_side_m = longest;
    } else {
      answer.changes.push_back("size_m: not three lengths in metres, ignored");
    }
  }
  void confidence() {
    const json* value = find("confidence");
    if (!value || failed()) return;
    const double number = value->is_number() ? value->get<double>() : -1;
    if (kUnitRange.holds(number)) {
      answer.confidence = number;
    } else {
      answer.changes.push_back("confidence: not a number from 0 to 1, ignored");
    }
  }
  void name_confidence() {
    const json* value = find("name_confidence");
    if (!value || failed()) return;
    const double number = value->is_number() ? value->get<double>() : -1;
    if (kUnitRange.holds(number)) {
      answer.name_confidence = number;
    } else {
      answer.changes.push_back("name_confidence: not a number from 0 to 1, ignored");
    }
  }
  void sources() {
    const json* value = find("kb_ids");
    if (!value || failed() || !value->is_array()) return;
    size_t unknown = 0;
    for (size_t i = 0; i < std::min(value->size(), kMaxAnswerSources); ++i) {
      const json& one = (*value)[i];
      const std::string id = one.is_string() ? shown_text(one.get_ref<const std::string&>(), 64) : "";
      const KnowledgeHit row = find_knowledge(id);
      if (row.material || row.object) {
        answer.kb_ids.push_back(row.id);
      } else {
        ++unknown;
      }
    }
    if (unknown > 0)
      answer.changes.push_back("kb_ids: " + std::to_string(unknown) + " without a row, ignored");
  }
  void ignored_fields() {
    size_t ignored = 0;
    for (const auto& item : object_.items()) {
      const std::string& field = item.key();
      const bool known = std::any_of(std::begin(kKnownFields), std::end(kKnownFields),
                                     [&](const char* one) { return field == one; });
      if (!known && ++ignored <= 4)
        answer.changes.push_back(shown_text(field, 32) + ": not a field of the schema, ignored");
    }
  }

  // Stores the error as a line of prompts/complaints.json.
  void fail(std::string_view line,
            std::initializer_list<std::pair<std::string_view, std::string_view>> slots = {}) {
    if (!error_) error_ = invalid_data(words_.say(line, slots));
  }
  bool failed() const { return error_.has_value(); }
  const Error& error() const { return *error_; }

  Answer answer;

 private:
  void other_type(const json& value, const std::string& field, const char* form) {
    fail("other_type",
         {{"field", field}, {"type", std::string("JSON ") + value.type_name()}, {"form", words_.say(form)}});
  }
  // Unit of a field's numbers.
  std::string unit_of(const std::string& field) const {
    if (field.find("mass_g") != std::string::npos) return words_.say("unit_mass");
    return field.starts_with("young_mpa") ? words_.say("unit_young") : "";
  }

  const json& object_;
  const MessageTemplates& words_;
  std::optional<Error> error_;
};

}  // namespace

Result<Answer> read_answer(std::string_view text, const MessageTemplates& words) {
  const auto object = answer_object(text, words);
  if (!object) return object.error();
  Reader read(*object, words);
  Answer& answer = read.answer;
  answer.name = read.text("name", 80);
  answer.description = read.text("description", 240);
  answer.evidence = read.text("evidence", 320);
  read.fill();
  read.behaviour();
  read.parts();
  if (const json* mass = read.require("mass_g", "form_mass"); mass && !read.failed()) {
    answer.mass_kg = read.span(*mass, "mass_g", kMassRange_kg, 1e-3).value_or(Span3{});
  }
  read.alternatives();
  if (const json* young = read.find("young_mpa"); young && !read.failed()) {
    answer.youngs_modulus_pa = read.span(*young, "young_mpa", kYoungsRange_pa, 1e6);
  }
  if (const json* structure = read.find("structure_s"); structure && !read.failed()) {
    answer.structure_coefficient = read.span(*structure, "structure_s", kStructureRange, 1);
  }
  read.plasticity();
  if (read.require("fragile", "form_boolean") && !read.failed())
    answer.fragile = read.boolean("fragile").value_or(false);
  read.name_confidence();
  answer.replica = read.boolean("is_replica");
  answer.friction = read.optional_number("friction", kFrictionRange);
  answer.restitution = read.optional_number("restitution", kUnitRange);
  read.confidence();
  read.size();
  read.sources();
  read.ignored_fields();
  if (read.failed()) return read.error();
  return std::move(answer);
}

}  // namespace livegs
