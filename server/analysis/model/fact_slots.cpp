// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/fact_slots.h"

#include <algorithm>
#include <vector>

#include "analysis/estimate/object_classes.h"
#include "analysis/estimate/physics_values.h"
#include "analysis/knowledge/name_match.h"
#include "analysis/text/prompt_text.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

constexpr size_t kMaxMaterialLength = 60;
// From this share on, an opening is named, and the area may be that of both sides of a wall.
constexpr double kMinOpenness = 0.15;

using Words = const MessageTemplates&;

std::string size_text(const MeshFacts& mesh, Words words) {
  const Eigen::Vector3d box_cm = 100 * sorted_box_m(mesh);
  return words.say("size", {{"long", format_text("%.3g", box_cm[0])},
                            {"middle", format_text("%.3g", box_cm[1])},
                            {"short", format_text("%.3g", box_cm[2])},
                            {"height", format_text("%.3g", 100 * mesh.size_m.y())}});
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
  const double area_cm2 = 1e4 * mesh.area_m2;
  const std::string area = mesh.openness > kMinOpenness
                               ? words.say("mesh_both_sides", {{"area", format_text("%.4g", area_cm2)},
                                                               {"half", format_text("%.4g", 0.5 * area_cm2)}})
                               : words.say("mesh_outer", {{"area", format_text("%.4g", area_cm2)}});
  std::string more;
  if (mesh.openness > kMinOpenness)
    more += words.say("mesh_open", {{"share", format_text("%.0f", 100 * mesh.openness)}});
  if (mesh.thin_sheet > 0.3) more += words.say("mesh_sheet");
  if (mesh.rod > 0.3) more += words.say("mesh_rod");
  if (mesh.piece_count > 1) more += words.say("mesh_pieces", {{"count", std::to_string(mesh.piece_count)}});
  return words.say("mesh", {{"volume", format_text("%.4g", 1e6 * mesh.volume_m3)},
                            {"area", area},
                            {"wall", format_text("%.3g", 1e3 * mesh.mean_wall_m)},
                            {"solidity", format_text("%.0f", 100 * mesh.solidity)},
                            {"more", more}});
}

std::string looks_text(const AppearanceFacts& look, Words words) {
  const auto byte = [](float channel) { return static_cast<int>(255 * channel + 0.5f); };
  return words.say("looks", {{"rgb", format_text("%02x%02x%02x", byte(look.mean_rgb.x()),
                                                 byte(look.mean_rgb.y()), byte(look.mean_rgb.z()))},
                             {"saturation", format_text("%.2f", look.saturation)},
                             {"hue_spread", format_text("%.2f", look.hue_spread)}});
}

// The nearest objects whose values are known, not estimated offline. Of equally near ones, the newest first.
std::string neighbours_text(std::span<const SceneObjectFacts> neighbours, Words words) {
  std::vector<const SceneObjectFacts*> known;
  for (size_t i = neighbours.size(); i-- > 0;) {
    if (neighbours[i].analysed) known.push_back(&neighbours[i]);
  }
  std::stable_sort(known.begin(), known.end(),
                   [](const auto* a, const auto* b) { return a->distance_m < b->distance_m; });
  if (known.size() > kMaxNeighbourSlots) known.resize(kMaxNeighbourSlots);
  std::string lines;
  for (const SceneObjectFacts* other : known) {
    std::string values;
    if (other->mass_kg > 0)
      values += words.say("neighbour_mass", {{"mass", format_text("%.4g", 1e3 * other->mass_kg)}});
    // A sidecar may contain any text.
    for (const std::string& word : {other->material, other->behavior}) {
      if (!word.empty())
        values += words.say("neighbour_word", {{"word", line_text(word, kMaxMaterialLength)}});
    }
    const Eigen::Vector3d& size_m = other->size_m;
    lines += (lines.empty() ? "" : "\n") +
             words.say("neighbour",
                       {{"name", quoted_text(other->name)},
                        {"known", values},
                        {"size", words.say("neighbour_size", {{"length", format_text("%.3g", size_m.x())},
                                                              {"height", format_text("%.3g", size_m.y())},
                                                              {"depth", format_text("%.3g", size_m.z())}})},
                        {"distance", format_text("%.3g", other->distance_m)}});
  }
  return lines;
}

// The usual form of things of the object's name, without masses: step 7 of the gate fuses those, and the
// prior counts once. Empty if the tables do not have the name.
std::string category_text(const ObjectFacts& facts, Words words) {
  const NameMatch match = match_name(facts.name);
  if (!match.row || match.tail != NameMatch::Tail::Nothing) return "";
  const v1::PhysicalParameters usual = estimate_offline(facts);
  const v1::EstimatedValue& wall_m = usual.wall_thickness_m();
  const std::string wall =
      wall_m.best() > 0
          ? words.say("category_wall", {{"wall_low", format_text("%.2g", 1e3 * wall_m.low())},
                                        {"wall_high", format_text("%.2g", 1e3 * wall_m.high())}})
          : "";
  return words.say("category", {{"label", line_text(usual.label(), kMaxMaterialLength)},
                                {"material", usual.material()},
                                {"fill", fill_name(usual.fill())},
                                {"wall", wall},
                                {"behaviour", usual.behavior() == v1::Physics::RIGID ? "rigid" : "elastic"}});
}

}  // namespace

std::map<std::string, std::string> fact_slots(const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                                              std::span<const SceneObjectFacts> neighbours,
                                              const MessageTemplates& words) {
  std::map<std::string, std::string> slots;
  if (!facts.name.empty()) slots["name"] = facts.name;
  slots["size"] = size_text(facts.mesh, words);
  if (facts.scale_known) {
    slots["scale"] = words.say("scale_known");
  } else {
    slots["scale_off"] = "2";
    slots["mass_off"] = "8";
  }
  slots["mesh"] = mesh_text(facts.mesh, words);
  if (facts.appearance.mean_opacity > 0) slots["looks"] = looks_text(facts.appearance, words);
  if (std::string near = neighbours_text(neighbours, words); !near.empty())
    slots["neighbours"] = std::move(near);
  if (std::string usual = category_text(facts, words); !usual.empty()) slots["category"] = std::move(usual);
  if (std::string given = given_text(offline, words); !given.empty()) slots["told"] = std::move(given);
  return slots;
}

}  // namespace livegs
