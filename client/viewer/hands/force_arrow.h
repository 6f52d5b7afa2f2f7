// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "splat/camera.h"

namespace livegs {

// Length of a force arrow in metres per newton, constant for an object. The object's weight is drawn at 0.4
// of its size, so that forces on light and heavy objects are both visible.
double arrow_metres_per_newton(double mass_kg, double size_m);

// Widths of every arrow and the length of its head, in pixels.
inline constexpr double kArrowShaftWidth_px = 8, kArrowHeadWidth_px = 22, kArrowHeadLength_px = 18;

// An arrow over the picture. It starts at the point of application and has the direction of the projected
// force. Its length is that of the projected force, foreshortened by the perspective at that point, up to
// three tenths of the picture's shorter side; the tip stays within the picture.
struct ProjectedArrow {
  // Outline in pixels: tail left, neck left, barb left, tip, barb right, neck right, tail right.
  std::array<Eigen::Vector2d, 7> outline_px;
};
// Nothing if the point is behind the eye or the arrow is shorter than a few pixels.
std::optional<ProjectedArrow> project_arrow(const Camera& camera, const Eigen::Vector3d& point_m,
                                            const Eigen::Vector3d& force_n, double metres_per_newton);

}  // namespace livegs
