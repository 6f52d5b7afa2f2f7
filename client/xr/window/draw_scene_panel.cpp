// SPDX-License-Identifier: Apache-2.0
#include "xr/window/draw_scene_panel.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "xr/window/widgets.h"

namespace livegs {
namespace {

constexpr float kLabel_px = 84;  // names of the fields, at scale 1

void field_name(const char* name) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(name);
  ImGui::SameLine(scaled(kLabel_px));
  ImGui::SetNextItemWidth(-1);
}

}  // namespace

void ScenePanelDrawer::draw(const ScenePanel& panel, SceneActions& actions) {
  draw_steps(panel, actions);
  draw_list(panel, actions);
  draw_objects(panel, actions);
  if (panel.fields) draw_fields(panel, actions);
  draw_view(panel, actions);
  // At the end, so that nothing moves under the mouse.
  coloured(kDimInk, panel.progress.empty() ? " " : panel.progress);
  if (!panel.notice.empty()) coloured(kRefusalInk, panel.notice);
}

void ScenePanelDrawer::draw_steps(const ScenePanel& panel, SceneActions& actions) {
  actions.undo = button("Undo", !panel.undo.empty());
  tip(panel.undo.empty() ? "Nothing to undo" : "Undo " + panel.undo + " (Ctrl+Z)");
  ImGui::SameLine();
  actions.redo = button("Redo", !panel.redo.empty());
  tip(panel.redo.empty() ? "Nothing to redo" : "Redo " + panel.redo + " (Ctrl+Y)");
  ImGui::SameLine();
  actions.save = button("Save", panel.unsaved);
  tip("Write " + (panel.file.empty() ? "a scene file" : panel.file) + " (Ctrl+S)");
  ImGui::SameLine();
  if (button("Save as")) {
    file_ = panel.suggested_file;
    ImGui::OpenPopup("save as");
  }
  if (ImGui::BeginPopup("save as")) {
    ImGui::TextUnformatted("File in the scene's folder");
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(scaled(240));
    const bool entered = input_text("##file", file_, ImGuiInputTextFlags_EnterReturnsTrue);
    const bool saves = ImGui::Button("Save##as");
    ImGui::SameLine();
    const bool replaces = ImGui::Button("Replace");
    tip("Save even if the file exists; the old one is kept as FILE.bak");
    if ((entered || saves || replaces) && !file_.empty()) {
      actions.save_as = file_;
      actions.replace = replaces;
      ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
  }
  ImGui::PushStyleColor(ImGuiCol_Text, kDimInk);
  ImGui::TextWrapped("%s%s", panel.file.empty() ? "not saved yet" : panel.file.c_str(),
                     panel.unsaved && !panel.file.empty() ? ", unsaved changes" : "");
  ImGui::PopStyleColor();
}

void ScenePanelDrawer::draw_list(const ScenePanel& panel, SceneActions& actions) {
  ImGui::SetNextItemWidth(-1);
  std::array<char, kMaxFieldText> search{};
  std::snprintf(search.data(), search.size(), "%s", search_.c_str());
  if (ImGui::InputTextWithHint("##search", "Search", search.data(), search.size())) search_ = search.data();
  const float rows = static_cast<float>(std::clamp<size_t>(panel.entries.size(), 2, 7));
  ImGui::BeginChild("list", {0, rows * ImGui::GetTextLineHeightWithSpacing() + 8}, true);
  for (size_t i = 0; i < panel.entries.size(); ++i) {
    const ScenePanel::Entry& entry = panel.entries[i];
    if (!search_.empty() && !contains_text(entry.name, search_) && !contains_text(entry.group, search_))
      continue;
    ImGui::PushID(static_cast<int>(i));
    bool drawn = !entry.hidden, locked = entry.locked;
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {0, 0});
    if (ImGui::Checkbox("##drawn", &drawn)) actions.hidden = {i, !drawn};
    tip(drawn ? "Drawn" : "Hidden");
    ImGui::SameLine();
    if (ImGui::Checkbox("##locked", &locked)) actions.locked = {i, locked};
    tip(locked ? "Locked: cannot be edited" : "Not locked");
    ImGui::PopStyleVar();
    ImGui::SameLine();
    const std::string line = entry.group.empty() ? entry.name : entry.name + "  (" + entry.group + ")";
    if (ImGui::Selectable(line.c_str(), entry.selected)) {
      actions.clicked = i;
      actions.extends = ImGui::GetIO().KeyCtrl || ImGui::GetIO().KeyShift;
    }
    tip(line);
    ImGui::PopID();
  }
  if (panel.entries.empty()) ImGui::TextWrapped("Empty: add an asset, or drop files on the window.");
  ImGui::EndChild();
}

void ScenePanelDrawer::draw_objects(const ScenePanel& panel, SceneActions& actions) {
  const bool any = panel.selected > 0;
  if (button("Add")) {
    actions.opened_assets = true;
    choosing_.clear();
    ImGui::OpenPopup("add");
  }
  tip("Add an asset of the scene's folder; or drop files on the window");
  if (ImGui::BeginPopup("add")) {
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    ImGui::SetNextItemWidth(scaled(260));
    input_text("##asset", choosing_);
    ImGui::BeginChild("assets", {scaled(260), scaled(180)});
    for (size_t i = 0; i < panel.assets.size(); ++i) {
      if (!choosing_.empty() && !contains_text(panel.assets[i], choosing_)) continue;
      if (ImGui::Selectable(panel.assets[i].c_str())) {
        actions.add = i;
        ImGui::CloseCurrentPopup();
      }
    }
    if (panel.assets.empty()) ImGui::TextDisabled("The scene's folder has no splat files.");
    ImGui::EndChild();
    ImGui::EndPopup();
  }
  ImGui::SameLine();
  actions.duplicate = button("Duplicate", any);
  tip("Ctrl+D");
  ImGui::SameLine();
  actions.remove = button("Delete", any);
  tip("Delete");
  actions.drop = button("Drop", any);
  tip("Move it down onto what is below");
  ImGui::SameLine();
  actions.frame = button("Frame");
  tip("Show the selection, or everything (F)");
  for (size_t i = 0; i < panel.kTakeTool; ++i) {
    if (i % 3 != 0) ImGui::SameLine();  // rows of fixed length: a scroll bar must not change the layout
    if (ImGui::RadioButton(panel.kTools[i], panel.tool == static_cast<int>(i)))
      actions.tool = static_cast<int>(i);
    tip(std::string("Key ") + std::to_string(i + 1));
  }
  bool snap = panel.snap, grid = panel.grid;
  ImGui::SameLine();
  if (ImGui::Checkbox("Snap", &snap)) actions.snap = snap;
  tip("To 0.1 m, 15 degrees and 10 %; Ctrl while dragging does so too");
  ImGui::SameLine();
  if (ImGui::Checkbox("Grid", &grid)) actions.grid = grid;
  tip("A metre a square, on the floor");
  if (!panel.room) return;
  constexpr int kTake = static_cast<int>(ScenePanel::kTakeTool);
  if (ImGui::RadioButton(panel.kTools[kTake], panel.tool == kTake)) actions.tool = kTake;
  tip("Point at a thing in the captured room; a click takes it out (key 6)");
}

void ScenePanelDrawer::draw_fields(const ScenePanel& panel, SceneActions& actions) {
  const ScenePanel::Fields& fields = *panel.fields;
  ImGui::Separator();
  field_name("Name");
  actions.name = fields_.text_field("##name", fields.name);
  field_name("What is it?");
  actions.label =
      fields_.choice("##label", fields.label.empty() ? fields.label_hint : fields.label, panel.labels);
  tip("Mass and material are estimated from this at once");
  field_name("Material");
  actions.material = fields_.choice("##material", fields.material.empty() ? "as estimated" : fields.material,
                                    panel.materials);
  field_name("Behaviour");
  if (ImGui::BeginCombo("##behavior", panel.kBehaviors[static_cast<size_t>(fields.behavior)])) {
    for (size_t i = 0; i < panel.kBehaviors.size(); ++i) {
      if (ImGui::Selectable(panel.kBehaviors[i], fields.behavior == static_cast<int>(i)))
        actions.behavior = static_cast<int>(i);
    }
    ImGui::EndCombo();
  }
  if (fields.longest_side_m > 0) {
    field_name("Size, m");
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.4g", fields.longest_side_m);
    double value = 0;
    if (const auto typed = fields_.text_field("##size", text.data());
        typed && std::sscanf(typed->c_str(), "%lf", &value) == 1)
      actions.longest_side_m = value;
    tip("Longest side");
  }
  field_name("Position, m");
  actions.position_m = fields_.numbers("##position", fields.position_m, "%.3f");
  field_name("Turn, deg");
  actions.angles_deg = fields_.numbers("##angles", fields.angles_deg, "%.1f");
  tip("Yaw about y, pitch about x, roll about z");
  field_name("Group");
  actions.group = fields_.text_field("##group", fields.group);
  tip("Objects of one group are selected together");
  if (!fields.taken) return;
  actions.put_back = button("Put back");
  tip("Back into the captured room, as it was");
}

void ScenePanelDrawer::draw_view(const ScenePanel& panel, SceneActions& actions) {
  ImGui::Separator();
  field_name("View");
  if (ImGui::BeginCombo("##views", "Saved views")) {
    for (size_t i = 0; i < panel.bookmarks.size(); ++i) {
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::SmallButton("x")) actions.delete_bookmark = i;
      tip("Delete this view");
      ImGui::SameLine();
      if (ImGui::Selectable(panel.bookmarks[i].c_str())) actions.go_bookmark = i;
      ImGui::PopID();
    }
    if (panel.bookmarks.empty()) ImGui::TextDisabled("None yet");
    ImGui::Separator();
    ImGui::SetNextItemWidth(scaled(160));
    input_text("##new view", bookmark_);
    ImGui::SameLine();
    if (button("Keep this view", !bookmark_.empty())) {
      actions.keep_bookmark = bookmark_;
      bookmark_.clear();
      ImGui::CloseCurrentPopup();
    }
    ImGui::EndCombo();
  }
  std::array<float, 3> rgb = panel.background.value_or(std::array<float, 3>{0.0f, 0.0f, 0.0f});
  field_name("Background");
  ImGui::ColorEdit3("##background", rgb.data(), ImGuiColorEditFlags_NoInputs);
  if (ImGui::IsItemDeactivatedAfterEdit()) actions.background = rgb;
}

}  // namespace livegs
