// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "splat/camera.h"

namespace livegs {

// A force on an object of this mass and size is drawn 0.4 of its size long where it equals its weight, so
// that a pull that lifts a hat and one that lifts a stool are both seen. Metres a newton; constant for an
// object.
double arrow_metres_per_newton(double mass_kg, double size_m);

// An arrow as it is seen: a flat shape that stands in the world along the force and faces the eye, so that it
// is foreshortened and shrinks with distance like a thing. Length and thickness go with the force.
struct ProjectedArrow {
  // Around it: tail left, neck left, barb left, tip, barb right, neck right, tail right. Pixels.
  std::array<Eigen::Vector2d, 7> outline_px;
};
// Nothing when a part of it is behind the eye or it would be shorter than a few pixels.
std::optional<ProjectedArrow> project_arrow(const Camera& camera, const Eigen::Vector3d& point_m,
                                            const Eigen::Vector3d& force_n, double metres_per_newton);

}  // namespace livegs
