// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "splat/camera.h"

namespace livegs {

// A camera that shows all of `bounds_m` from the front (+z) and slightly above. `azimuth_rad` moves it around
// to the right, `elevation_rad` up.
inline constexpr double kDefaultElevation_rad = 0.35;
inline constexpr double kDefaultVerticalFov_rad = 0.7;
Camera frame_bounds(const Eigen::AlignedBox3d& bounds_m, int width, int height, double azimuth_rad = 0.0,
                    double elevation_rad = kDefaultElevation_rad);

// Columns of a picture.
struct PictureColumns {
  double left_px = 0, right_px = 0;
};
// The nearest camera of this direction that shows all boxes within the columns; default: the whole picture.
// They fill nine tenths of the width or of the height. If all boxes are empty, it shows a cubic metre.
Camera frame_boxes(std::span<const Eigen::AlignedBox3d> boxes_m, int width, int height,
                   double azimuth_rad = 0.0, double elevation_rad = kDefaultElevation_rad,
                   const std::optional<PictureColumns>& free = {});

// Bounds from the 1st to the 99th percentile along each axis, which exclude haze and floaters; empty without
// positions.
Eigen::AlignedBox3d robust_bounds(const std::vector<Eigen::Vector3f>& positions_m);

}  // namespace livegs
