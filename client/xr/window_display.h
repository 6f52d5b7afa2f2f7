// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "xr/display.h"
#include "xr/window/draw_arrow.h"
#include "xr/window/window_panels.h"

namespace livegs {

// What the mouse and the keys did in one frame of a window. Pixels from the top left of its contents. What a
// panel has taken for itself is left out.
struct WindowInput {
  Eigen::Vector2d mouse_px{0, 0}, moved_px{0, 0};
  double scrolled = 0;  // notches, up is positive
  bool left = false, middle = false, right = false;
  bool shoot = false;                              // space went down
  bool over_panel = false;                         // the mouse is a panel's
  bool hide = false, pause = false, step = false;  // H, P, the full stop went down
  bool home = false;                               // the Home key went down
  int jump = 0;                                    // the right arrow went down: 1; the left: -1
  Eigen::Vector3d flown{0, 0, 0};                  // D - A, E - Q, S - W: -1, 0 or 1 each
  double passed_s = 0;                             // since the frame before; 0 in the first
};

// What stands over the picture.
struct WindowOverlay {
  std::vector<WindowArrow> arrows;
  std::optional<WindowAim> aim;
  std::string sentence;  // empty: none
  WindowPanels panels;
};

// A desktop window: GLFW, with Dear ImGui over the picture. Pictures come as images, whatever drew them, and
// are stretched over the window. On the thread that opened it.
class WindowDisplay : public Display {
 public:
  // Whether open() would succeed: opens a window that is not seen. Before there is one.
  static bool is_possible();
  // Unavailable, with the remedy, when there is no display or no OpenGL.
  static Result<std::unique_ptr<WindowDisplay>> open(const std::string& title, int width, int height);

  virtual void set_camera(const Camera& camera) = 0;  // of the next wait_frame
  virtual const WindowInput& input() const = 0;       // of the last wait_frame
  virtual Eigen::Vector2i size_px() const = 0;        // of the window's contents now
  virtual double refresh_hz()
      const = 0;  // of the monitor that most of the window is on; 0 where it is not known
  virtual void set_overlay(WindowOverlay overlay) = 0;
  virtual const PanelActions& actions() const = 0;  // on the panels of the last submit
  // What the next submit shows, panels included, is kept in `image`, which outlives it.
  virtual void keep_next(Image& image) = 0;
};

}  // namespace livegs
