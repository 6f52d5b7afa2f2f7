// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/fact_slots.h"

#include <algorithm>
#include <vector>

#include "analysis/object_kinds.h"
#include "analysis/physics_values.h"
#include "analysis/prompt_text.h"
#include "core/format_text.h"

namespace livegs {
namespace {

constexpr size_t kNearestMaterials = 3;
constexpr size_t kLongestMaterial = 60, kLongestReason = 600;

constexpr const char* kScaleKnown = "metric";

std::string size_text(const Eigen::Vector3d& size_m) {
  return format_text("%.3g x %.3g x %.3g m", size_m.x(), size_m.y(), size_m.z());
}

std::string range(const v1::EstimatedValue& value, double factor, const char* unit) {
  return format_text("%.4g %s (%.4g to %.4g)", factor * value.best(), unit, factor * value.low(),
                     factor * value.high());
}

// A text of a line of its own, whatever it holds: what ends a line or imitates a quote is gone.
std::string inside_line(std::string_view text, size_t longest) {
  const std::string quoted = quoted_text(text, longest);
  return quoted.substr(1, quoted.size() - 2);
}

// What a person or the scene's author told, by its field.
std::string told_text(const v1::PhysicalParameters& known) {
  std::string line;
  for (const PhysicsValue& value : physics_values()) {
    const v1::EstimatedValue& one = (known.*value.get)();
    if (one.source() != v1::EstimatedValue::PERSON && one.source() != v1::EstimatedValue::SCENE) continue;
    line += (line.empty() ? "" : ", ") + format_text("%s %.4g", value.name, one.best());
  }
  return line;
}

std::string mesh_text(const MeshFacts& mesh) {
  const Eigen::Vector3d box_cm = 100 * sorted_box_m(mesh);
  std::string line = format_text(
      "smallest box %.3g x %.3g x %.3g cm, encloses %.4g cm3, surface %.4g cm2, mean wall 2V/A %.3g mm, "
      "%.0f %% of its convex hull",
      box_cm[0], box_cm[1], box_cm[2], 1e6 * mesh.volume_m3, 1e4 * mesh.area_m2, 1e3 * mesh.mean_wall_m,
      100 * mesh.solidity);
  if (mesh.openness > 0.15) line += format_text(", %.0f %% open", 100 * mesh.openness);
  if (mesh.thin_sheet > 0.3) line += ", thin sheet";
  if (mesh.rod > 0.3) line += ", rod";
  if (mesh.piece_count > 1) line += format_text(", %d pieces", mesh.piece_count);
  return line;
}

std::string looks_text(const AppearanceFacts& look) {
  return format_text(
      "mean colour #%02x%02x%02x, saturation %.2f, spread of hue %.2f rad, opacity %.2f, gloss %.2f",
      static_cast<int>(255 * look.mean_rgb.x() + 0.5f), static_cast<int>(255 * look.mean_rgb.y() + 0.5f),
      static_cast<int>(255 * look.mean_rgb.z() + 0.5f), look.saturation, look.hue_spread, look.mean_opacity,
      look.gloss);
}

std::string neighbours_text(std::span<const SceneObjectFacts> neighbours) {
  std::string lines;
  const size_t told = std::min(neighbours.size(), kToldNeighbours);
  for (size_t i = 0; i < told; ++i) {
    const SceneObjectFacts& other = neighbours[neighbours.size() - 1 - i];  // newest first
    if (!lines.empty()) lines += '\n';
    lines += "- " + quoted_text(other.name) + ": ";
    if (other.mass_kg > 0) lines += format_text("%.4g g, ", 1e3 * other.mass_kg);
    // A sidecar may say anything.
    if (!other.material.empty()) lines += inside_line(other.material, kLongestMaterial) + ", ";
    if (!other.behavior.empty()) lines += inside_line(other.behavior, kLongestMaterial) + ", ";
    lines += format_text("%.3g x %.3g x %.3g m, %.3g m away%s", other.size_m.x(), other.size_m.y(),
                         other.size_m.z(), other.distance_m, other.analysed ? "" : " (estimated offline)");
  }
  return lines;
}

std::string material_line(const MaterialRow& row) {
  return format_text("- %s (%s): %.4g to %.4g kg/m3, Young's modulus %.3g MPa (%.3g to %.3g), plasticity %.2g%s",
                     row.name.c_str(), row.material_class.c_str(), row.density_kg_m3.low, row.density_kg_m3.high,
                     1e-6 * row.youngs_modulus_pa.best, 1e-6 * row.youngs_modulus_pa.low,
                     1e-6 * row.youngs_modulus_pa.high, row.plasticity, row.fragile ? ", fragile" : "");
}

// The materials of the likely kinds, likeliest first.
std::string materials_text(const Kinds& kinds) {
  std::vector<const MaterialRow*> nearest;
  for (const Kind& kind : kinds.kinds) {
    const MaterialRow* material = kind.material ? kind.material : &material_row(kind.row->material);
    if (std::find(nearest.begin(), nearest.end(), material) == nearest.end()) nearest.push_back(material);
    if (nearest.size() == kNearestMaterials) break;
  }
  std::string lines;
  for (const MaterialRow* row : nearest) {
    if (!lines.empty()) lines += '\n';
    lines += material_line(*row);
  }
  return lines;
}

std::string offline_text(const v1::PhysicalParameters& offline) {
  return format_text("%s of %s, mass %s, %s, confidence %.2f; ",
                     inside_line(offline.label(), kLongestMaterial).c_str(),
                     inside_line(offline.material(), kLongestMaterial).c_str(),
                     range(offline.mass_kg(), 1e3, "g").c_str(),
                     v1::Physics::Behavior_Name(offline.behavior()).c_str(), offline.confidence()) +
         inside_line(offline.mass_kg().reason(), kLongestReason);
}

}  // namespace

std::map<std::string, std::string> fact_slots(const ObjectFacts& facts, const v1::PhysicalParameters& offline,
                                              std::span<const SceneObjectFacts> neighbours) {
  std::map<std::string, std::string> slots;
  if (!facts.name.empty()) slots["name"] = facts.name;
  slots["size"] = size_text(facts.mesh.size_m);
  if (facts.scale_known) {
    slots["scale"] = kScaleKnown;
  } else {
    slots["scale_off"] = "2";
    slots["mass_off"] = "8";
  }
  slots["mesh"] = mesh_text(facts.mesh);
  if (facts.appearance.mean_opacity > 0) slots["looks"] = looks_text(facts.appearance);
  if (!neighbours.empty()) slots["neighbours"] = neighbours_text(neighbours);
  slots["materials"] = materials_text(object_kinds(facts));
  slots["offline"] = offline_text(offline);
  if (std::string told = told_text(offline); !told.empty()) slots["told"] = std::move(told);
  return slots;
}

std::string fact_words() {
  MeshFacts mesh;
  mesh.openness = mesh.thin_sheet = mesh.rod = 1;
  mesh.piece_count = 2;
  MaterialRow row{};
  row.fragile = true;
  v1::PhysicalParameters known;
  for (const PhysicsValue& value : physics_values()) {
    (known.*value.mutable_value)()->set_source(v1::EstimatedValue::PERSON);
  }
  SceneObjectFacts other;
  other.mass_kg = 1;
  other.material = other.behavior = "x";
  const SceneObjectFacts others[] = {other};
  std::string words;
  for (const std::string& text : {size_text({1, 2, 3}), std::string(kScaleKnown), mesh_text(mesh), looks_text({}), neighbours_text(others), material_line(row),
                                  offline_text(known), told_text(known)}) {
    words += text + "\n";
  }
  return words;
}

}  // namespace livegs
