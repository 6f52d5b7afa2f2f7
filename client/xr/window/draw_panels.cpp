// SPDX-License-Identifier: Apache-2.0
#include "xr/window/draw_panels.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "xr/window/draw_frame_graph.h"
#include "xr/window/widgets.h"

namespace livegs {
namespace {

// Lengths at scale 1.
constexpr float kMargin_px = 10, kGap_px = 4, kLeftWidth_px = 300, kRightWidth_px = 390, kTextWidth_px = 84,
                kValueWidth_px = 64;
constexpr float kFineDrag = 0.1f;  // of a slider, with Shift
// The Scene panel is open at first if there is room for all of it below the Run panel.
constexpr float kMinScenePanel_px = 560;
// Share of the height of a lower window that an open Scene panel has. A higher share leaves less for Run.
constexpr float kSceneShare = 0.6f;

}  // namespace

std::optional<std::pair<double, double>> columns_beside_panels(double width_px, bool recorded, double scale) {
  constexpr double kMinPanelShare = 0.3;
  const double left_px = scale * (kMargin_px + kLeftWidth_px),
               right_px = recorded ? width_px : width_px - scale * (kRightWidth_px + kMargin_px);
  return right_px - left_px >= kMinPanelShare * width_px ? std::optional(std::pair(left_px, right_px))
                                                         : std::nullopt;
}

void PanelDrawer::place(Panel panel, float left_px, float top_px, float width_px, float height_px,
                        float max_px) {
  ImGui::SetNextWindowPos({left_px, top_px}, stacked_ || resized_ ? ImGuiCond_Always : ImGuiCond_Once);
  if (stacked_)
    ImGui::SetNextWindowCollapsed(open_ != panel, ImGuiCond_Always);
  else if (resized_)
    ImGui::SetNextWindowCollapsed(false, ImGuiCond_Always);
  ImGui::SetNextWindowSize({width_px, height_px});
  ImGui::SetNextWindowSizeConstraints({width_px, 0}, {width_px, std::max(max_px, 1.0f)});
}

// A click on a panel's title bar opens or closes it.
void PanelDrawer::see_whether_open(Panel panel) {
  if (!stacked_ || ImGui::IsWindowCollapsed() == (open_ != panel)) return;
  open_ = open_ == panel ? Panel::None : panel;
}

PanelActions PanelDrawer::draw(const WindowPanels& panels, float width_px, float height_px) {
  PanelActions actions;
  if (!panels.shown) return actions;
  if (panels.loading) {
    draw_loading(*panels.loading, width_px, height_px);
    return actions;
  }
  resized_ = width_px != width_px_ || height_px != height_px_ || scale_ != scaled(1);
  scale_ = scaled(1);
  width_px_ = width_px;
  height_px_ = height_px;
  const bool stacks = width_px < scaled(kMinSideBySideWidth_px);
  const bool selected = panels.objects.selected.has_value();
  if (stacks && !stacked_) open_ = selected ? Panel::Objects : Panel::Run;
  if (selected && !had_selection_) open_ = Panel::Objects;
  had_selection_ = selected;
  stacked_ = stacks;
  // The Run panel shows the notice.
  if (!panels.run.notice.empty() && !had_notice_) open_ = Panel::Run;
  had_notice_ = !panels.run.notice.empty();

  const float across_px = std::max(1.0f, width_px - 2 * scaled(kMargin_px)),
              down_px = height_px - 2 * scaled(kMargin_px);
  // The title bars of the other panels in the same column stay visible.
  const float bar_px = scaled(kGap_px) + ImGui::GetFrameHeight();
  const float scene_px = panels.scene.available ? bar_px : 0;
  const float max_px = stacked_ ? down_px - bar_px - scene_px : down_px;
  // Side by side, Run leaves room for an open Scene panel below it, and scrolls.
  const float run_max_px =
      stacked_      ? max_px
      : scene_open_ ? down_px - scaled(kGap_px) - std::min(scaled(kMinScenePanel_px), kSceneShare * down_px)
                    : down_px - scene_px;
  place(Panel::Run, scaled(kMargin_px), scaled(kMargin_px), std::min(scaled(kLeftWidth_px), across_px), 0,
        run_max_px);
  ImGui::Begin("Run", nullptr, ImGuiWindowFlags_NoResize);
  see_whether_open(Panel::Run);
  draw_run(panels.run, actions);
  if (!panels.run.recorded) {
    ImGui::Separator();
    draw_force(panels.force, actions);
  }
  const float below_px = scaled(kMargin_px) + ImGui::GetWindowHeight() + scaled(kGap_px);
  ImGui::End();
  if (panels.run.recorded) return actions;

  const float right_px =
      std::min(scaled(kRightWidth_px),
               stacked_ ? across_px : width_px - scaled(kLeftWidth_px) - 3 * scaled(kMargin_px));
  // With an object selected the panel takes the full height: automatic sizing lags one picture behind.
  place(Panel::Objects, stacked_ ? scaled(kMargin_px) : width_px - right_px - scaled(kMargin_px),
        stacked_ ? below_px : scaled(kMargin_px), right_px, panels.objects.selected ? max_px : 0, max_px);
  ImGui::Begin("Objects", nullptr, ImGuiWindowFlags_NoResize);
  see_whether_open(Panel::Objects);
  draw_objects(panels.objects, panels.scene.materials, actions);
  const float below_objects_px = below_px + ImGui::GetWindowHeight() + scaled(kGap_px);
  ImGui::End();
  if (!panels.scene.available) return actions;

  // Closed at first where it would cover the picture.
  const float top_px = stacked_ ? below_objects_px : below_px;
  if (!stacked_ && !std::exchange(scene_seen_, true))
    ImGui::SetNextWindowCollapsed(height_px - top_px < scaled(kMinScenePanel_px), ImGuiCond_Always);
  place(Panel::Scene, scaled(kMargin_px), top_px, std::min(scaled(kLeftWidth_px), across_px), 0,
        std::max(height_px - top_px - scaled(kMargin_px), ImGui::GetFrameHeight()));
  ImGui::SetNextWindowPos({scaled(kMargin_px), top_px});  // the Run panel changes its height
  ImGui::Begin("Scene", nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove);
  see_whether_open(Panel::Scene);
  scene_open_ = !ImGui::IsWindowCollapsed();
  scene_.draw(panels.scene, actions.scene);
  ImGui::End();
  return actions;
}

void PanelDrawer::draw_loading(const LoadingPanel& loading, float width_px, float height_px) {
  ImGui::SetNextWindowPos({0.5f * width_px, 0.5f * height_px}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(scaled(kRightWidth_px), width_px - 2 * scaled(kMargin_px)), 0});
  ImGui::Begin("Loading", nullptr,
               ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse);
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, kPictureInk);
  ImGui::ProgressBar(static_cast<float>(loading.share), {-1, 0});
  ImGui::PopStyleColor();
  coloured(kDimInk, loading.text);
  ImGui::End();
}

void PanelDrawer::draw_run(const RunPanel& run, PanelActions& actions) {
  if (run.waiting) {
    actions.start = button("Start", true, -1);
    coloured(kNoteInk, "Halted at the beginning. Press Start or P.");
    if (!run.notice.empty()) coloured(kRefusalInk, run.notice);
    return;
  }
  const float third = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  if (button(run.paused ? "Resume" : "Pause", true, third)) actions.pause = !run.paused;
  ImGui::SameLine();
  actions.step = button("Step", true, third);
  ImGui::SameLine();
  actions.reset = button(run.recorded ? "Restart" : run.loading ? "Loading" : "Reset", !run.loading, third);
  if (!run.notice.empty()) coloured(kRefusalInk, run.notice);
  for (const std::string& line : run.lines) coloured(kDimInk, line);
  if (!run.recorded) draw_frame_graph(run.graph);
  if (!run.latency.empty()) coloured(kDimInk, run.latency);
  if (!run.help.empty() && ImGui::CollapsingHeader("Mouse and keys")) coloured(kDimInk, run.help);
}

void PanelDrawer::draw_force(const ForcePanel& force, PanelActions& actions) {
  ImGui::TextUnformatted("Force");
  coloured(force.ready ? kInk : kDimInk, force.target);
  if (!force.ready && force.progress.empty()) return;
  PanelActions::Force set{force.size_n, force.duration_s, force.yaw_deg, force.pitch_deg};
  bool changed = false;
  const auto slider = [&](const char* name, const char* format, double& value, double low, double high,
                          ImGuiSliderFlags flags = 0) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(name);
    ImGui::SameLine(scaled(kTextWidth_px));
    ImGui::SetNextItemWidth(-scaled(kValueWidth_px));
    changed |=
        ImGui::SliderScalar((std::string("##") + name).c_str(), ImGuiDataType_Double, &value, &low, &high, "",
                            flags | ImGuiSliderFlags_NoInput | ImGuiSliderFlags_NoRoundToFormat);
    ImGui::SameLine();  // on the same line: the slider's grab would overlap it
    ImGui::Text(format, value);
  };
  slider("Size", "%.3g N", set.size_n, 0.1, 1000, ImGuiSliderFlags_Logarithmic);
  slider("Time", "%.2f s", set.duration_s, 0.05, 10, ImGuiSliderFlags_Logarithmic);
  slider("Yaw", "%.0f deg", set.yaw_deg, -180, 180);
  slider("Pitch", "%.0f deg", set.pitch_deg, -90, 90);
  if (changed) actions.force = set;
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  actions.apply_force = button("Apply", force.progress.empty(), half);
  ImGui::SameLine();
  actions.record_force = button("Apply and record", force.progress.empty(), half);
  coloured(kDimInk, force.progress.empty() ? force.sentence : force.progress);
}

void PanelDrawer::draw_objects(const ObjectsPanel& objects, const std::vector<std::string>& materials,
                               PanelActions& actions) {
  if (ImGui::BeginTable("list", 3)) {
    ImGui::TableSetupColumn("name", ImGuiTableColumnFlags_WidthStretch, 1.0f);
    ImGui::TableSetupColumn("kind", ImGuiTableColumnFlags_WidthStretch, 2.0f);
    ImGui::TableSetupColumn("mass", ImGuiTableColumnFlags_WidthFixed, scaled(kTextWidth_px));
    for (size_t i = 0; i < objects.entries.size(); ++i) {
      const ObjectsPanel::Entry& entry = objects.entries[i];
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::PushID(static_cast<int>(i));
      if (ImGui::Selectable(entry.name.c_str(), objects.selected == i, ImGuiSelectableFlags_SpanAllColumns)) {
        actions.selected = i;
      }
      ImGui::PopID();
      ImGui::PushStyleColor(ImGuiCol_Text, kDimInk);
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(entry.kind.c_str());
      ImGui::TableNextColumn();
      ImGui::SetCursorPosX(ImGui::GetCursorPosX() + ImGui::GetContentRegionAvail().x -
                           ImGui::CalcTextSize(entry.mass.c_str()).x);
      ImGui::TextUnformatted(entry.mass.c_str());
      ImGui::PopStyleColor();
    }
    ImGui::EndTable();
  }
  if (objects.selected) {
    ImGui::Separator();
    for (const std::string& fact : objects.facts) ImGui::TextWrapped("%s", fact.c_str());
    draw_parts(objects, materials, actions);
    ImGui::Spacing();
    for (size_t i = 0; i < objects.rows.size(); ++i) draw_row(i, objects.rows[i], actions);
    if (objects.fragile) {
      bool fragile = *objects.fragile;
      if (ImGui::Checkbox("Fragile: breaks on impact", &fragile)) actions.fragile = fragile;
    }
    for (const ObjectsPanel::Message& message : objects.messages) {
      coloured(message.refusal ? kRefusalInk : kNoteInk, message.text);
    }
    if (!objects.proposal.empty()) {
      coloured(kNoteInk, objects.proposal);
      actions.accept = button("Accept");
      ImGui::SameLine();
      actions.decline = button("Decline");
    }
  } else {
    coloured(kDimInk, "Click an object, here or in the picture, to view and edit its material.");
  }
  ImGui::Spacing();
  if (objects.selected) {
    actions.undo = button("Undo");
    ImGui::SameLine();
    actions.redo = button("Redo");
    same_line_if_it_fits("Analyse again");
    actions.analyse = button("Analyse again", objects.progress.empty());
    same_line_if_it_fits("Analyse all");
  }
  actions.analyse_all = button("Analyse all", objects.progress.empty());
  if (!objects.progress.empty()) coloured(kDimInk, objects.progress);
}

void PanelDrawer::draw_parts(const ObjectsPanel& objects, const std::vector<std::string>& materials,
                             PanelActions& actions) {
  const bool open = objects.division && ImGui::CollapsingHeader("Parts");
  actions.parts_open = open;
  if (open) return parts_.draw(*objects.division, materials, actions);
  if (objects.parts.empty()) return;
  bool shown = objects.parts_shown;
  if (ImGui::Checkbox("Show parts", &shown)) actions.show_parts = shown;
  const float side_px = ImGui::GetTextLineHeight();
  for (const ObjectsPanel::Part& part : objects.parts) {  // always, so that nothing moves at a tick
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddRectFilled(
        at, {at.x + side_px, at.y + side_px},
        ImGui::ColorConvertFloat4ToU32({part.rgb[0], part.rgb[1], part.rgb[2], 1}));
    ImGui::Dummy({side_px, side_px});
    ImGui::SameLine();
    ImGui::TextWrapped("%s", part.text.c_str());
  }
}

void PanelDrawer::draw_row(size_t index, const ValueRow& row, PanelActions& actions) {
  ImGui::PushID(row.name.c_str());
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(row.name.c_str());
  const float width = ImGui::GetContentRegionAvail().x;

  ImGui::SameLine(0.45f * width);
  const bool held = held_ == row.name;
  float position = held ? held_position_ : static_cast<float>(row.position);
  ImGui::SetNextItemWidth(0.55f * width - scaled(kTextWidth_px) - ImGui::GetStyle().ItemSpacing.x +
                          ImGui::GetStyle().WindowPadding.x);
  const ImVec2 from = ImGui::GetCursorScreenPos();
  ImGui::SliderFloat("##slider", &position, 0, 1, "",
                     ImGuiSliderFlags_NoInput | ImGuiSliderFlags_NoRoundToFormat);
  const bool active = ImGui::IsItemActive(), released = ImGui::IsItemDeactivatedAfterEdit();
  const ImVec2 size = ImGui::GetItemRectSize();
  tip("Shift: ten times finer");
  if (held && ImGui::GetIO().KeyShift)
    position = std::clamp(held_position_ + kFineDrag * ImGui::GetIO().MouseDelta.x / size.x, 0.0f, 1.0f);
  if (row.range_high > row.range_low) {  // range of the estimate
    const float inside = size.x - 4;
    ImGui::GetWindowDrawList()->AddRectFilled(
        {from.x + 2 + inside * static_cast<float>(row.range_low), from.y + size.y - 4},
        {from.x + 2 +
             std::max(inside * static_cast<float>(row.range_high),
                      inside * static_cast<float>(row.range_low) + 2),
         from.y + size.y - 1},
        kPictureInk, 1);
  }
  if (released) actions.released = {index, position};
  if (active) {
    held_ = row.name;
    held_position_ = position;
  } else if (held) {
    held_.clear();
  }

  ImGui::SameLine();
  ImGui::SetNextItemWidth(scaled(kTextWidth_px));
  const std::string shown = held && row.text_at ? row.text_at(held_position_) : row.value;
  std::array<char, 64> text{};  // ImGui keeps the text while it is edited
  std::snprintf(text.data(), text.size(), "%s", shown.c_str());
  if (ImGui::InputText("##value", text.data(), text.size(),
                       ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll)) {
    actions.typed = {index, std::string(text.data())};
  }

  coloured(kDimInk, row.origin);
  if (row.edited) {  // on the same line, so that nothing moves when it is removed
    const char* name = "To the estimate";
    ImGui::SameLine(width + ImGui::GetStyle().WindowPadding.x - ImGui::CalcTextSize(name).x -
                    2 * ImGui::GetStyle().FramePadding.x);
    if (ImGui::SmallButton(name)) actions.estimated = index;
    tip("Removes the value that was set by hand; Undo brings it back");
  }
  if (!row.reason.empty()) coloured(kDimInk, row.reason);
  ImGui::Spacing();
  ImGui::PopID();
}

}  // namespace livegs
