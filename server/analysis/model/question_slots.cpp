// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/question_slots.h"

#include "analysis/text/json_text.h"
#include "analysis/text/prompt_text.h"

namespace livegs {
namespace {

constexpr int kMaterialHits = 3;

}  // namespace

std::map<std::string, std::string> complete_slots(const AnalysisQuestion& question, const ToolBox& tools) {
  std::map<std::string, std::string> slots = question.slots;
  const auto fill = [&](const char* slot, const char* tool, const OrderedJson& arguments) {
    if (!slots[slot].empty()) return;
    std::string result = tools.call(tool, dump_json(arguments));
    if (!result.starts_with("{\"error\"")) slots[slot] = std::move(result);
  };
  // Sanitised, because the arguments of a tool are JSON and a name may contain any bytes.
  const std::string name = plain_text(slots["name"], 80);
  fill("mesh", "mesh_facts", OrderedJson::object());
  if (!tools.scene().empty()) fill("neighbours", "list_scene_objects", OrderedJson::object());
  if (!name.empty()) {
    fill("category", "category_prior",
         {{"name", name}, {"length_m", nullptr}, {"width_m", nullptr}, {"height_m", nullptr}});
    fill("materials", "material_search", {{"query", name}, {"k", kMaterialHits}});
  }
  return slots;
}

}  // namespace livegs
