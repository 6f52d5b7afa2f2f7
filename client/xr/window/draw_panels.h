// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "xr/window/draw_parts.h"
#include "xr/window/draw_scene_panel.h"
#include "xr/window/window_panels.h"

namespace livegs {

// The columns of the window between the panels, or, for a recording, next to Run; none if too little space is
// left. `scale`: WindowDisplay::ui_scale().
std::optional<std::pair<double, double>> columns_beside_panels(double width_px, bool recorded,
                                                               double scale = 1);

// Draws the panels of a window with Dear ImGui and reports the user's actions. Keeps the position of a slider
// that is dragged. Call between ImGui's NewFrame and Render.
//
// Run is on the left with Scene below it, and Objects on the right; the user can move them until the window
// is resized. In a window narrower than kMinSideBySideWidth_px they are stacked and at most one is open:
// opening one closes the other. Panels that are higher than their room scroll. The first selection opens
// Objects, and a notice opens Run.
class PanelDrawer {
 public:
  PanelActions draw(const WindowPanels& panels, float width_px, float height_px);

  static constexpr float kMinSideBySideWidth_px = 700;  // at scale 1

 private:
  enum class Panel { None, Run, Objects, Scene };
  // Before and after a panel is begun. `max_px`: maximum height; `height_px` 0: fits the contents.
  void place(Panel panel, float left_px, float top_px, float width_px, float height_px, float max_px);
  void see_whether_open(Panel panel);

  void draw_loading(const LoadingPanel& loading, float width_px, float height_px);
  void draw_run(const RunPanel& run, PanelActions& actions);
  void draw_force(const ForcePanel& force, PanelActions& actions);
  void draw_objects(const ObjectsPanel& objects, const std::vector<std::string>& materials,
                    PanelActions& actions);
  void draw_parts(const ObjectsPanel& objects, const std::vector<std::string>& materials,
                  PanelActions& actions);
  void draw_row(size_t index, const ValueRow& row, PanelActions& actions);

  float width_px_ = 0, height_px_ = 0, scale_ = 0;  // of the last call: window size, scale of the panels
  bool resized_ = false, stacked_ = false;
  Panel open_ = Panel::Run;  // when stacked
  bool had_selection_ = false;
  bool had_notice_ = false;
  std::string held_;  // name of the row whose slider is dragged
  float held_position_ = 0;
  PartsDrawer parts_;
  ScenePanelDrawer scene_;
  bool scene_seen_ = false;  // the Scene panel has been shown
  bool scene_open_ = false;  // it was in the last picture
};

}  // namespace livegs
