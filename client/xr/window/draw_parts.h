// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "xr/window/text_fields.h"
#include "xr/window/window_panels.h"

namespace livegs {

// Draws the section in which the parts of an object are edited. Keeps texts while they are typed. Internal to
// this room.
class PartsDrawer {
 public:
  // `materials`: suggestions.
  void draw(const PartsPanel& panel, const std::vector<std::string>& materials, PanelActions& actions);

 private:
  void draw_part(const PartsPanel& panel, size_t part, const std::vector<std::string>& materials,
                 PanelActions& actions);
  void draw_boxes(const PartsPanel& panel, PanelActions& actions);
  // Whether the corner was changed. `body_m`: where it begins when it is no longer open.
  bool draw_corner(const char* name, const std::string& id,
                   const std::optional<std::array<double, 3>>& body_m,
                   std::optional<std::array<double, 3>>& corner_m);

  TextFields fields_;
};

}  // namespace livegs
