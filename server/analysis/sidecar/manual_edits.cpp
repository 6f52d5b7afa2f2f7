// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/sidecar/manual_edits.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "analysis/estimate.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/gate/answer.h"
#include "core/text/shown_text.h"

namespace livegs {
namespace {

using v1::Physics;

std::string exact(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// Behaviour, fill and fragility as text.
std::string behavior_text(const v1::PhysicalParameters& p) { return std::to_string(p.behavior()); }
std::string fill_text(const v1::PhysicalParameters& p) { return std::to_string(p.fill()); }
std::string fragile_text(const v1::PhysicalParameters& p) { return p.fragile() ? "true" : "false"; }

// Parts as one line of JSON.
std::string decided_parts(const v1::PhysicalParameters& p) {
  Physics only;
  *only.mutable_parts() = p.parts();
  std::string text;
  google::protobuf::util::JsonPrintOptions print;
  print.preserve_proto_field_names = true;
  (void)google::protobuf::util::MessageToJsonString(only, &text, print);
  return text;
}

}  // namespace

void seal(v1::PhysicsFile& file) {
  auto& decided = *file.mutable_as_decided();
  decided.clear();
  if (!file.has_physics()) return;
  const v1::PhysicalParameters& p = file.physics();
  for (const PhysicsValue& value : physics_values()) {
    if ((p.*value.has)()) decided[value.name] = exact((p.*value.get)().best());
  }
  decided["label"] = p.label();
  decided["behavior"] = behavior_text(p);
  decided["fill"] = fill_text(p);
  decided["fragile"] = fragile_text(p);
  if (p.parts_size() > 0) decided["parts"] = decided_parts(p);
}

Result<bool> take_manual_edits(v1::PhysicsFile& file) {
  if (!file.has_physics()) return false;
  const bool by_hand = file.as_decided().empty();
  v1::PhysicalParameters& p = *file.mutable_physics();
  const auto& decided = file.as_decided();
  const auto differs = [&](const char* name, const std::string& now) {
    const auto before = decided.find(name);
    return before == decided.end() || before->second != now;
  };
  Physics edits;
  for (const PhysicsValue& value : physics_values()) {
    if (!(p.*value.has)()) continue;
    const double best = (p.*value.get)().best();
    if (!differs(value.name, exact(best))) continue;
    (edits.*value.set)(best);
    // Checked alone, so that the message names the field.
    Physics alone;
    (alone.*value.set)(best);
    if (auto checked = check_scene_physics(alone); !checked) {
      const std::string& what = checked.error().message;
      return invalid_argument("physics." + std::string(value.name) + ".best" + what.substr(what.find(':')));
    }
    const auto before = decided.find(value.name);
    if (before != decided.end()) {
      (p.*value.mutable_value)()->set_best(std::strtod(before->second.c_str(), nullptr));
    } else if (!by_hand) {
      (p.*value.mutable_value)()->Clear();
    }
  }
  // A modulus and the resistance derived from it are one statement.
  if (edits.has_youngs_modulus_pa()) edits.clear_deformation_resistance();
  if (!Physics::Behavior_IsValid(p.behavior())) {
    return invalid_argument("physics.behavior: is " + behavior_text(p) + "; give STATIC, RIGID or ELASTIC");
  }
  if (!Physics::Fill_IsValid(p.fill())) {
    return invalid_argument("physics.fill: is " + fill_text(p) + "; give SOLID, SHELL, OPEN_SHELL or FILLED");
  }
  if (p.parts_size() > 0 && (by_hand || (decided.contains("parts") && differs("parts", decided_parts(p))))) {
    *edits.mutable_parts() = p.parts();
    Physics alone;
    *alone.mutable_parts() = p.parts();
    if (auto checked = check_scene_physics(alone); !checked)
      return invalid_argument("physics." + checked.error().message);
    Physics before;
    if (!by_hand && !google::protobuf::util::JsonStringToMessage(decided.at("parts"), &before).ok())
      return invalid_argument("as_decided: was changed by hand; delete the file or undo the change");
    *p.mutable_parts() = before.parts();
  }
  bool renamed = false;
  const auto number = [&](const char* name) { return std::atoi(decided.at(name).c_str()); };
  if (by_hand) {
    edits.set_behavior(p.behavior());
    edits.set_fill(p.fill());
    if (p.fragile()) edits.set_fragile(true);
    if (!p.label().empty()) file.set_name(p.label()), renamed = true;
    file.clear_physics();
  } else {
    if (decided.contains("behavior") && differs("behavior", behavior_text(p))) {
      edits.set_behavior(p.behavior());
      p.set_behavior(static_cast<Physics::Behavior>(number("behavior")));
    }
    if (decided.contains("fill") && differs("fill", fill_text(p))) {
      edits.set_fill(p.fill());
      p.set_fill(static_cast<Physics::Fill>(number("fill")));
    }
    if (decided.contains("fragile") && differs("fragile", fragile_text(p))) {
      edits.set_fragile(p.fragile());
      p.set_fragile(!p.fragile());
    }
    if (decided.contains("label") && differs("label", p.label())) {
      file.set_name(p.label());
      p.set_label(decided.at("label"));
      renamed = true;
    }
    if (!Physics::Behavior_IsValid(p.behavior()) || !Physics::Fill_IsValid(p.fill())) {
      return invalid_argument("as_decided: was changed by hand; delete the file or undo the change");
    }
  }
  const bool any = renamed || edits.ByteSizeLong() > 0;
  if (any) merge_edits(*file.mutable_edits(), edits);
  return any;
}

std::string overridden_edits(const Physics& edits, const Physics& written) {
  const auto set_fields = [](const Physics& physics) {
    std::vector<const google::protobuf::FieldDescriptor*> fields;
    physics.GetReflection()->ListFields(physics, &fields);  // by number
    return fields;
  };
  const auto by_author = set_fields(written);
  std::string names;
  for (const auto* field : set_fields(edits)) {
    if (std::find(by_author.begin(), by_author.end(), field) == by_author.end()) continue;
    names += (names.empty() ? "" : ", ") + field->name();
  }
  if (names.empty()) return {};
  return "the edit of " + names +
         " has no effect, because the scene file sets it; remove it there to edit it here";
}

std::string physics_name(std::string_view name) { return shown_text(name, 80); }

void merge_edits(v1::Physics& edits, const v1::Physics& later) {
  if (later.has_mass_kg()) edits.clear_density_kg_m3();
  if (later.has_density_kg_m3()) edits.clear_mass_kg();
  if (later.has_youngs_modulus_pa()) edits.clear_deformation_resistance();
  if (later.has_deformation_resistance()) edits.clear_youngs_modulus_pa();
  // A list replaces the earlier one.
  if (later.interior_rgb_size() > 0) edits.clear_interior_rgb();
  if (later.parts_size() > 0) edits.clear_parts();
  edits.MergeFrom(later);
}

Result<void> remove_edits(v1::Physics& edits, std::span<const std::string> fields) {
  bool any = false;
  for (const std::string& name : fields) {
    const auto* field = v1::Physics::descriptor()->FindFieldByName(name);
    if (!field)
      return invalid_argument("physics: \"" + shown_text(name, 60) + "\" is not a field of Physics");
    const auto& reflection = *v1::Physics::GetReflection();
    any = any ||
          (field->is_repeated() ? reflection.FieldSize(edits, field) > 0 : reflection.HasField(edits, field));
    reflection.ClearField(&edits, field);
  }
  if (!any) return not_found("physics: none of these values was set by hand");
  return {};
}

}  // namespace livegs
