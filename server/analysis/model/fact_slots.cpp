// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/fact_slots.h"

#include <algorithm>
#include <vector>

#include "analysis/estimate/object_classes.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/knowledge/table_search.h"
#include "analysis/text/prompt_text.h"
#include "core/format_text.h"

namespace livegs {
namespace {

constexpr size_t kSimilarMaterialCount = 3;
constexpr size_t kMaxMaterialLength = 60, kMaxReasonLength = 600;

using Words = const MessageTemplates&;

std::string size_text(const Eigen::Vector3d& size_m, Words words) {
  return words.say("size", {{"length", format_text("%.3g", size_m.x())},
                            {"height", format_text("%.3g", size_m.y())},
                            {"depth", format_text("%.3g", size_m.z())}});
}

// Values given by a user or the scene's author, by field.
std::string given_text(const v1::PhysicalParameters& known, Words words) {
  std::string line;
  for (const PhysicsValue& value : physics_values()) {
    const v1::EstimatedValue& one = (known.*value.get)();
    if (!is_locked(one)) continue;
    line += (line.empty() ? "" : ", ") +
            words.say("told", {{"field", value.name}, {"value", format_text("%.4g", one.best())}});
  }
  return line;
}

std::string mesh_text(const MeshFacts& mesh, Words words) {
  const Eigen::Vector3d box_cm = 100 * sorted_box_m(mesh);
  std::string more;
  if (mesh.openness > 0.15)
    more += words.say("mesh_open", {{"share", format_text("%.0f", 100 * mesh.openness)}});
  if (mesh.thin_sheet > 0.3) more += words.say("mesh_sheet");
  if (mesh.rod > 0.3) more += words.say("mesh_rod");
  if (mesh.piece_count > 1) more += words.say("mesh_pieces", {{"count", std::to_string(mesh.piece_count)}});
  return words.say("mesh", {{"long", format_text("%.3g", box_cm[0])},
                            {"middle", format_text("%.3g", box_cm[1])},
                            {"short", format_text("%.3g", box_cm[2])},
                            {"volume", format_text("%.4g", 1e6 * mesh.volume_m3)},
                            {"area", format_text("%.4g", 1e4 * mesh.area_m2)},
                            {"wall", format_text("%.3g", 1e3 * mesh.mean_wall_m)},
                            {"solidity", format_text("%.0f", 100 * mesh.solidity)},
                            {"more", more}});
}

std::string looks_text(const AppearanceFacts& look, Words words) {
  const auto byte = [](float channel) { return static_cast<int>(255 * channel + 0.5f); };
  return words.say("looks", {{"rgb", format_text("%02x%02x%02x", byte(look.mean_rgb.x()),
                                                 byte(look.mean_rgb.y()), byte(look.mean_rgb.z()))},
                             {"saturation", format_text("%.2f", look.saturation)},
                             {"hue_spread", format_text("%.2f", look.hue_spread)},
                             {"opacity", format_text("%.2f", look.mean_opacity)},
                             {"gloss", format_text("%.2f", look.gloss)}});
}

std::string neighbours_text(std::span<const SceneObjectFacts> neighbours, Words words) {
  std::string lines;
  const size_t count = std::min(neighbours.size(), kMaxNeighbourSlots);
  for (size_t i = 0; i < count; ++i) {
    const SceneObjectFacts& other = neighbours[neighbours.size() - 1 - i];  // newest first
    std::string known;
    if (other.mass_kg > 0)
      known += words.say("neighbour_mass", {{"mass", format_text("%.4g", 1e3 * other.mass_kg)}});
    // A sidecar may contain any text.
    for (const std::string& word : {other.material, other.behavior}) {
      if (!word.empty())
        known += words.say("neighbour_word", {{"word", line_text(word, kMaxMaterialLength)}});
    }
    lines += (lines.empty() ? "" : "\n") +
             words.say("neighbour", {{"name", quoted_text(other.name)},
                                     {"known", known},
                                     {"size", size_text(other.size_m, words)},
                                     {"distance", format_text("%.3g", other.distance_m)},
                                     {"estimated", other.analysed ? "" : words.say("neighbour_estimated")}});
  }
  return lines;
}

std::string material_line(const MaterialRow& row, Words words) {
  const Span3 &density = row.density_kg_m3, &young = row.youngs_modulus_pa;
  return words.say("material", {{"name", row.name},
                                {"class", row.material_class},
                                {"density_low", format_text("%.4g", density.low)},
                                {"density_high", format_text("%.4g", density.high)},
                                {"young", format_text("%.3g", 1e-6 * young.best)},
                                {"young_low", format_text("%.3g", 1e-6 * young.low)},
                                {"young_high", format_text("%.3g", 1e-6 * young.high)},
                                {"plasticity", format_text("%.2g", row.plasticity)},
                                {"fragile", row.fragile ? words.say("material_fragile") : ""}});
}

// Materials of the likely classes, likeliest first, then of their parts, then those most similar to the
// first.
std::string materials_text(const ObjectClasses& kinds, Words words) {
  std::vector<const MaterialRow*> nearest;
  const auto add = [&](const MaterialRow* material) {
    if (nearest.size() < kSimilarMaterialCount &&
        std::find(nearest.begin(), nearest.end(), material) == nearest.end())
      nearest.push_back(material);
  };
  for (const ObjectClass& kind : kinds.kinds)
    add(kind.material ? kind.material : &material_row(kind.row->material));
  for (const ObjectClass& kind : kinds.kinds) {
    for (const ObjectPart& part : kind.row->parts) add(find_material_row(part.material));
  }
  for (const MaterialRow* material : similar_materials(*nearest.front(), kSimilarMaterialCount))
    add(material);
  std::string lines;
  for (const MaterialRow* row : nearest) {
    if (!lines.empty()) lines += '\n';
    lines += material_line(*row, words);
  }
  return lines;
}

std::string offline_text(const v1::PhysicalParameters& offline, Words words) {
  const v1::EstimatedValue& mass = offline.mass_kg();
  return words.say("offline", {{"label", line_text(offline.label(), kMaxMaterialLength)},
                               {"material", line_text(offline.material(), kMaxMaterialLength)},
                               {"mass", format_text("%.4g", 1e3 * mass.best())},
                               {"mass_low", format_text("%.4g", 1e3 * mass.low())},
                               {"mass_high", format_text("%.4g", 1e3 * mass.high())},
                               {"behaviour", v1::Physics::Behavior_Name(offline.behavior())},
                               {"confidence", format_text("%.2f", offline.confidence())},
                               {"reason", line_text(mass.reason(), kMaxReasonLength)}});
}

}  // namespace

std::map<std::string, std::string> fact_slots(const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                                              std::span<const SceneObjectFacts> neighbours,
                                              const MessageTemplates& words) {
  std::map<std::string, std::string> slots;
  if (!facts.name.empty()) slots["name"] = facts.name;
  slots["size"] = size_text(facts.mesh.size_m, words);
  if (facts.scale_known) {
    slots["scale"] = words.say("scale_known");
  } else {
    slots["scale_off"] = "2";
    slots["mass_off"] = "8";
  }
  slots["mesh"] = mesh_text(facts.mesh, words);
  if (facts.appearance.mean_opacity > 0) slots["looks"] = looks_text(facts.appearance, words);
  if (!neighbours.empty()) slots["neighbours"] = neighbours_text(neighbours, words);
  slots["materials"] = materials_text(object_classes(facts), words);
  slots["offline"] = offline_text(offline, words);
  if (std::string given = given_text(offline, words); !given.empty()) slots["told"] = std::move(given);
  return slots;
}

}  // namespace livegs
