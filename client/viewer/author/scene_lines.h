// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/pose.h"
#include "splat/camera.h"
#include "xr/window_display.h"

namespace livegs {

// Lines of the scene over a picture: world coordinates in metres, appended to `lines`. Parts behind the
// camera are omitted. Pure functions; any thread.
void add_line(const Camera& camera, Eigen::Vector3d a, Eigen::Vector3d b, WindowLine::Ink ink, float width_px,
              std::vector<WindowLine>& lines);
// The edges of a box in its own frame; none of an empty box.
void add_box(const Camera& camera, const Eigen::AlignedBox3d& box, const Pose& world_from_box,
             WindowLine::Ink ink, std::vector<WindowLine>& lines);

}  // namespace livegs
