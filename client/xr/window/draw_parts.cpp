// SPDX-License-Identifier: Apache-2.0
#include "xr/window/draw_parts.h"

#include <cstdio>
#include <utility>

#include "xr/window/widgets.h"

namespace livegs {
namespace {

using Kind = PartEdit::Kind;

constexpr float kShare_px = 40, kCorner_px = 72;  // at scale 1

PartEdit part_edit(Kind kind, const PartsPanel& panel, size_t part, std::string text = "") {
  PartEdit edit;
  edit.kind = kind;
  edit.object = panel.object;
  edit.part = part;
  edit.text = std::move(text);
  return edit;
}

}  // namespace

void PartsDrawer::draw(const PartsPanel& panel, const std::vector<std::string>& materials,
                       PanelActions& actions) {
  if (panel.parts.empty()) coloured(kDimInk, "One material; divide the object to give its parts their own.");
  for (size_t i = 0; i < panel.parts.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    draw_part(panel, i, materials, actions);
    ImGui::PopID();
  }
  if (button(panel.parts.size() < 2 ? "Divide" : "Add part", panel.body && !panel.full))
    actions.part_edit = part_edit(Kind::Add, panel, panel.parts.size());
  tip("A part in the upper half; then move its box");
  if (!panel.edited) return;
  same_line_if_it_fits("Parts to the estimate");
  if (button("Parts to the estimate")) actions.part_edit = part_edit(Kind::Estimate, panel, 0);
  tip("Removes the parts that were set by hand; Undo brings them back");
}

void PartsDrawer::draw_part(const PartsPanel& panel, size_t index, const std::vector<std::string>& materials,
                            PanelActions& actions) {
  const PartsPanel::Part& part = panel.parts[index];
  // With the object, so that a text that is being typed stays with it.
  const std::string id = panel.object + " " + std::to_string(index);
  const float gap_px = ImGui::GetStyle().ItemSpacing.x, side_px = ImGui::GetFrameHeight();
  const auto touched = [&] {
    if (ImGui::IsItemActivated()) actions.part_selected = index;
  };
  const ImVec2 at = ImGui::GetCursorScreenPos();
  if (ImGui::ColorButton("##colour", {part.rgb[0], part.rgb[1], part.rgb[2], 1},
                         ImGuiColorEditFlags_NoTooltip | ImGuiColorEditFlags_NoDragDrop, {side_px, side_px}))
    actions.part_selected = index;
  tip("Shows its boxes");
  if (panel.selected == index)
    ImGui::GetWindowDrawList()->AddRect(at, {at.x + side_px, at.y + side_px}, kInk, 0, 0, 2);
  // Name and material share the width that is left by the other widgets.
  const float percent_px = ImGui::CalcTextSize("%").x;
  const float text_px =
      0.5f * (ImGui::GetContentRegionAvail().x - 2 * side_px - scaled(kShare_px) - percent_px - 5 * gap_px);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(text_px);
  if (const auto name = fields_.text_field(("##name" + id).c_str(), part.name))
    actions.part_edit = part_edit(Kind::Name, panel, index, *name);
  touched();
  tip("Name of the part");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(text_px);
  if (const auto material = fields_.choice(("##material" + id).c_str(), part.material, materials))
    actions.part_edit = part_edit(Kind::Material, panel, index, *material);
  touched();
  tip(part.material);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(scaled(kShare_px));
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", 100 * part.share);
  double percent = 0;
  if (const auto typed = fields_.text_field(("##share" + id).c_str(), text.data());
      typed && std::sscanf(typed->c_str(), "%lf", &percent) == 1) {
    actions.part_edit = part_edit(Kind::Share, panel, index);
    actions.part_edit->share = 0.01 * percent;
  }
  touched();
  tip("Share of the mass; the others change in proportion");
  ImGui::SameLine(0, 0.5f * gap_px);
  ImGui::TextUnformatted("%");
  ImGui::SameLine();
  if (button("x", panel.parts.size() > 1, side_px)) actions.part_edit = part_edit(Kind::Remove, panel, index);
  tip("Removes the part");
  if (panel.selected == index) draw_boxes(panel, actions);
}

void PartsDrawer::draw_boxes(const PartsPanel& panel, PanelActions& actions) {
  const size_t part = panel.selected;
  const std::vector<PartsPanel::Box>& boxes = panel.parts[part].boxes;
  const float indent_px = ImGui::GetFrameHeight() + ImGui::GetStyle().ItemSpacing.x;
  ImGui::Indent(indent_px);
  if (boxes.empty())
    coloured(kDimInk, panel.parts.size() > 1 ? "No box: it has what is in no box." : "The whole object.");
  for (size_t i = 0; i < boxes.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const std::string id = panel.object + " " + std::to_string(part) + " " + std::to_string(i);
    PartsPanel::Box box = boxes[i];
    const PartsPanel::Box body = panel.body.value_or(PartsPanel::Box{});
    bool moved = draw_corner("from", "##from" + id, body.min_m, box.min_m);
    moved |= draw_corner("to", "##to" + id, body.max_m, box.max_m);
    const bool removed = button("Remove box");
    if (moved || removed) {
      actions.part_edit = part_edit(removed ? Kind::RemoveBox : Kind::MoveBox, panel, part);
      actions.part_edit->box = i;
      actions.part_edit->moved = box;
    }
    if (i + 1 == boxes.size()) same_line_if_it_fits("Add box");
    ImGui::PopID();
  }
  if (button("Add box", panel.body.has_value())) actions.part_edit = part_edit(Kind::AddBox, panel, part);
  tip("A box of the upper half. The last part with a box that contains a point has it.");
  ImGui::Unindent(indent_px);
}

bool PartsDrawer::draw_corner(const char* name, const std::string& id,
                              const std::optional<std::array<double, 3>>& body_m,
                              std::optional<std::array<double, 3>>& corner_m) {
  const float left_px = ImGui::GetCursorPosX();
  bool ends = corner_m.has_value(), changed = false;
  ImGui::BeginDisabled(!ends && !body_m);
  if (ImGui::Checkbox(name, &ends)) {
    corner_m = ends ? body_m : std::nullopt;
    changed = true;
  }
  ImGui::EndDisabled();
  tip("Without a tick the box is open on these sides");
  ImGui::SameLine(left_px + scaled(kCorner_px));
  if (!corner_m) {
    ImGui::TextDisabled("open");
    return changed;
  }
  if (const auto typed = fields_.numbers(id.c_str(), *corner_m, "%.4f")) {
    corner_m = typed;
    changed = true;
  }
  tip("x, y, z in metres, in the axes of the object at rest");
  return changed;
}

}  // namespace livegs
