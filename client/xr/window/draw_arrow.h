// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

struct ImDrawList;

namespace livegs {

// A force over the picture. Pixels from the top left.
struct WindowArrow {
  Eigen::Vector2d held_px;  // where it holds: marked by a ring
  // tail left, neck left, barb left, tip, barb right, neck right, tail right; none: too short to be seen
  std::optional<std::array<Eigen::Vector2d, 7>> outline_px;
  std::string label;
};
// What the mouse points at.
struct WindowAim {
  Eigen::Vector2d at_px;
  std::string label;
};

// Light inside a dark rim inside a light one, so that it stands out on any ground.
void draw_arrow(ImDrawList& list, const WindowArrow& arrow);
void draw_aim(ImDrawList& list, const WindowAim& aim);
// A sentence in the middle of the window's foot.
void draw_sentence(ImDrawList& list, const Eigen::Vector2d& size_px, const std::string& sentence);

}  // namespace livegs
