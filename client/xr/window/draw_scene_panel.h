// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>

#include "xr/window/window_panels.h"

namespace livegs {

// Draws the contents of the Scene panel. Keeps texts while they are typed.
class ScenePanelDrawer {
 public:
  void draw(const ScenePanel& panel, SceneActions& actions);

 private:
  void draw_steps(const ScenePanel& panel, SceneActions& actions);
  void draw_list(const ScenePanel& panel, SceneActions& actions);
  void draw_objects(const ScenePanel& panel, SceneActions& actions);
  void draw_fields(const ScenePanel& panel, SceneActions& actions);
  void draw_view(const ScenePanel& panel, SceneActions& actions);
  // A text that is reported when the user leaves its field or presses Enter.
  std::optional<std::string> text_field(const char* id, const std::string& value);
  std::optional<std::array<double, 3>> numbers(const char* id, const std::array<double, 3>& values,
                                               const char* format);
  // A list of suggestions with a field on top; the typed text is accepted too.
  std::optional<std::string> choice(const char* id, const std::string& value,
                                    const std::vector<std::string>& suggestions);

  std::string search_, editing_, edited_, choosing_, file_, bookmark_;
};

}  // namespace livegs
