// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "xr/window/text_fields.h"
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

  TextFields fields_;
  std::string search_, choosing_, file_, bookmark_;
};

}  // namespace livegs
