// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

struct ImDrawList;

namespace livegs {

// A force drawn over the picture. Pixels from the top left.
struct WindowArrow {
  Eigen::Vector2d held_px;  // point of application, marked by a ring
  // tail left, neck left, barb left, tip, barb right, neck right, tail right; none: too short to draw
  std::optional<std::array<Eigen::Vector2d, 7>> outline_px;
  std::string label;
};
// A line over the picture: of a gizmo, a grid, the outline of a selection.
struct WindowLine {
  enum class Ink { X, Y, Z, Plane, Selection, Part, Grid, Axis };
  std::vector<Eigen::Vector2d> points_px;
  Ink ink = Ink::Selection;
  float width_px = 2;
  bool arrow = false;  // the last part ends in a tip
  std::string label;   // at its middle; may be empty
};
// The object under the mouse.
struct WindowAim {
  Eigen::Vector2d at_px;
  std::string label;
};

// A light arrow with a dark and a light outline, visible on any background.
void draw_arrow(ImDrawList& list, const WindowArrow& arrow);
void draw_line(ImDrawList& list, const WindowLine& line);
void draw_aim(ImDrawList& list, const WindowAim& aim);
// Draws a sentence centred at the bottom of the window.
void draw_sentence(ImDrawList& list, const Eigen::Vector2d& size_px, const std::string& sentence);

}  // namespace livegs
