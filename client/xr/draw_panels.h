// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "xr/window_panels.h"

namespace livegs {

// Draws the panels of a window with Dear ImGui and says what a person did to them. It keeps where a slider
// that is held stands. Between ImGui's NewFrame and Render.
class PanelDrawer {
 public:
  PanelActions draw(const WindowPanels& panels, float width_px, float height_px);

 private:
  void draw_loading(const LoadingPanel& loading, float width_px, float height_px);
  void draw_run(const RunPanel& run, PanelActions& actions);
  void draw_force(const ForcePanel& force, PanelActions& actions);
  void draw_objects(const ObjectsPanel& objects, PanelActions& actions);
  void draw_row(size_t index, const ValueRow& row, PanelActions& actions);

  std::string held_;  // the name of the row whose slider is held
  float held_position_ = 0;
};

}  // namespace livegs
