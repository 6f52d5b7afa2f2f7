// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "splat/camera.h"

namespace livegs {

// A camera that shows all of `bounds_m` from the front (+z) and slightly above. `azimuth_rad` moves it around
// to the right, `elevation_rad` up.
inline constexpr double kDefaultElevation_rad = 0.35;
inline constexpr double kDefaultVerticalFov_rad = 0.7;
Camera frame_bounds(const Eigen::AlignedBox3d& bounds_m, int width, int height, double azimuth_rad = 0.0,
                    double elevation_rad = kDefaultElevation_rad);

}  // namespace livegs
