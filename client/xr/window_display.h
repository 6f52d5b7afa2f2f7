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

// Mouse and keyboard input of one window frame, from all events since the last one. Pixels from the top left
// of the contents. Input that a panel consumed is omitted.
struct WindowInput {
  // Mouse position when a button changed, else now; and its movement since the last frame or the press.
  Eigen::Vector2d mouse_px{0, 0}, moved_px{0, 0};
  double scrolled = 0;                 // notches, positive is up
  bool left = false;                   // down; a click is down in one frame at least
  bool middle = false, right = false;  // down at any time of the frame
  bool over_panel = false;             // the mouse is over a panel
  int shoot = 0, step = 0;             // presses of space and full stop
  bool hide = false, pause = false;    // H, P were pressed an odd number of times
  bool home = false;                   // Home was pressed
  int jump = 0;                        // presses of the right arrow less those of the left
  Eigen::Vector3d flown{0, 0, 0};      // D - A, E - Q, S - W: -1..1 each, share of the frame
  double passed_s = 0;                 // since the last frame; 0 in the first
  bool ctrl = false;                   // Ctrl is down
  // Presses of Ctrl+Z, Ctrl+Y or Ctrl+Shift+Z, Ctrl+S, Ctrl+D, Delete.
  int undo = 0, redo = 0, save = 0, duplicate = 0, remove = 0;
  bool frame = false;                // F was pressed
  std::optional<int> tool;           // 0..4: the key 1 to 5 was pressed
  std::vector<std::string> dropped;  // files that were dropped on the window
};

// Drawn over the picture.
struct WindowOverlay {
  std::vector<WindowArrow> arrows;
  std::vector<WindowLine> lines;
  std::optional<WindowAim> aim;
  std::string sentence;  // empty: none
  WindowPanels panels;
};

// Range of the scale of texts and panels.
inline constexpr double kMinUiScale = 0.5, kMaxUiScale = 4;

// A desktop window: GLFW, with Dear ImGui over the picture. Pictures are passed as images from any renderer
// and stretched over the window. Use on the thread that opened it.
class WindowDisplay : public Display {
 public:
  // Whether open() would succeed; opens a hidden window. Call before a window is open.
  static bool is_possible();
  // Unavailable, with the remedy, without a display or OpenGL.
  // `ui_scale`: of texts and panels; 0: that of the monitor. `scaled_size`: the size is for scale 1.
  static Result<std::unique_ptr<WindowDisplay>> open(const std::string& title, int width, int height,
                                                     double ui_scale = 0, bool scaled_size = false);

  // As Display::submit; without an image the last picture stays, and the window is redrawn only if overlay,
  // panels or window changed since.
  Result<void> submit(const PlannedFrame& frame, std::span<const Image> images) override = 0;
  virtual void set_camera(const Camera& camera) = 0;  // for the next wait_frame
  // The next wait_frame blocks until an event arrives or wake() is called, for up to this time; for less
  // while the panels are still changing after an event.
  virtual void set_wait(double seconds) = 0;
  virtual void wake() = 0;                       // any thread
  virtual const WindowInput& input() const = 0;  // of the last wait_frame
  virtual Eigen::Vector2i size_px() const = 0;   // current size of the contents
  virtual double ui_scale() const = 0;           // of texts and panels
  // Refresh rate of the monitor with the largest part of the window; 0 if unknown.
  virtual double refresh_hz() const = 0;
  virtual void set_overlay(WindowOverlay overlay) = 0;
  virtual const PanelActions& actions() const = 0;  // on the panels of the last submit
  // Copies the output of the next submit, panels included, to `image`, which must outlive it.
  virtual void keep_next(Image& image) = 0;
};

}  // namespace livegs
