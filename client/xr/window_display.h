// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "xr/display.h"

namespace livegs {

// What the mouse and the keys did in one frame of a window. Pixels from the top left of its contents. What a
// panel has taken for itself is left out.
struct WindowInput {
  Eigen::Vector2d mouse_px{0, 0}, moved_px{0, 0};
  double scrolled = 0;  // notches, up is positive
  bool left = false, middle = false, right = false;
  bool shoot = false;              // space went down
  Eigen::Vector3d flown{0, 0, 0};  // D - A, E - Q, S - W: -1, 0 or 1 each
  double passed_s = 0;             // since the frame before
};

// What stands over the picture.
struct WindowOverlay {
  struct Arrow {
    Eigen::Vector2d from_px, to_px;
    std::string label;
  };
  std::vector<Arrow> arrows;
  std::vector<std::string> status;   // lines of the first panel
  std::vector<std::string> objects;  // lines of the second
};

// A desktop window: GLFW, with Dear ImGui over the picture. Pictures come as images, whatever drew them, and
// are stretched over the window. On the thread that opened it.
class WindowDisplay : public Display {
 public:
  // Unavailable, with the remedy, when there is no display or no OpenGL.
  static Result<std::unique_ptr<WindowDisplay>> open(const std::string& title, int width, int height);

  virtual void set_camera(const Camera& camera) = 0;  // of the next wait_frame
  virtual const WindowInput& input() const = 0;       // of the last wait_frame
  virtual Eigen::Vector2i size_px() const = 0;        // of the window's contents now
  virtual void set_overlay(WindowOverlay overlay) = 0;
  // What the next submit shows, panels included, is kept in `image`, which outlives it.
  virtual void keep_next(Image& image) = 0;
};

}  // namespace livegs
