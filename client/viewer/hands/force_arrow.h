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

// The projection of an arrow: a flat shape in the world along the force that faces the eye, with perspective.
// Length and width are proportional to the force.
struct ProjectedArrow {
  // Outline in pixels: tail left, neck left, barb left, tip, barb right, neck right, tail right.
  std::array<Eigen::Vector2d, 7> outline_px;
};
// Nothing if a part is behind the eye or the arrow is shorter than a few pixels.
std::optional<ProjectedArrow> project_arrow(const Camera& camera, const Eigen::Vector3d& point_m,
                                            const Eigen::Vector3d& force_n, double metres_per_newton);

}  // namespace livegs
