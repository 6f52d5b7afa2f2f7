// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "xr/window/window_panels.h"

namespace livegs {

// The columns of a window between its panels, or, of a recording, beside Run; none where too little is left
// to show a scene in.
std::optional<std::pair<double, double>> columns_beside_panels(double width_px, bool recorded);

// Draws the panels of a window with Dear ImGui and says what a person did to them. It keeps where a slider
// that is held stands. Between ImGui's NewFrame and Render.
//
// Run stands on the left and Objects on the right, where a person may move them until the window changes its
// size. In one of less than kMinSideBySideWidth_px they stand one above the other, and at most one is open:
// what opens one closes the other. The first thing that is selected opens Objects, and what is out of order
// Run.
class PanelDrawer {
 public:
  PanelActions draw(const WindowPanels& panels, float width_px, float height_px);

  static constexpr float kMinSideBySideWidth_px = 700;

 private:
  enum class Panel { None, Run, Objects };
  // Before and after a panel is begun. `max_px`: of its height; `height_px` 0: as high as what it holds.
  void place(Panel panel, float left_px, float top_px, float width_px, float height_px, float max_px);
  void see_whether_open(Panel panel);

  void draw_loading(const LoadingPanel& loading, float width_px, float height_px);
  void draw_run(const RunPanel& run, PanelActions& actions);
  void draw_force(const ForcePanel& force, PanelActions& actions);
  void draw_objects(const ObjectsPanel& objects, PanelActions& actions);
  void draw_row(size_t index, const ValueRow& row, PanelActions& actions);

  float width_px_ = 0, height_px_ = 0;  // of the window the last time
  bool resized_ = false, stacked_ = false;
  Panel open_ = Panel::Run;  // of those that are stacked
  bool had_selection_ = false;
  bool had_notice_ = false;
  std::string held_;  // the name of the row whose slider is held
  float held_position_ = 0;
};

}  // namespace livegs
