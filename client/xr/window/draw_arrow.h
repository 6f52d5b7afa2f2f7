// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

struct ImDrawList;

namespace livegs {

// A force drawn over the picture. Pixels from the top left.
struct WindowArrow {
  Eigen::Vector2d held_px;  // point of application, marked by a ring
  // tail left, neck left, barb left, tip, barb right, neck right, tail right; none: too short to draw
  std::optional<std::array<Eigen::Vector2d, 7>> outline_px;
  std::string label;
};
// The object under the mouse.
struct WindowAim {
  Eigen::Vector2d at_px;
  std::string label;
};

// A light arrow with a dark and a light outline, visible on any background.
void draw_arrow(ImDrawList& list, const WindowArrow& arrow);
void draw_aim(ImDrawList& list, const WindowAim& aim);
// Draws a sentence centred at the bottom of the window.
void draw_sentence(ImDrawList& list, const Eigen::Vector2d& size_px, const std::string& sentence);

}  // namespace livegs
