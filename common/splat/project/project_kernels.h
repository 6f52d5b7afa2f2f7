// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/project/projected_kernel.h"
#include "splat/project/raster_options.h"

namespace livegs {

// The camera as projection uses it: image axes, x right, y down, z forward.
struct Projection {
  explicit Projection(const Camera& camera);

  Eigen::Matrix3d image_from_world;
  Eigen::Vector3d position_m;
  double focal_x_px, focal_y_px, centre_x_px, centre_y_px;
  // The slopes x/z and y/z at which the Jacobian is held: 15 % of the image beyond each edge, each side for
  // itself, since a headset's frustum is not symmetric.
  double min_slope_x, max_slope_x, min_slope_y, max_slope_y;
  double near_m;
  int width, height;
};

// The ellipse of one kernel and the depth that orders it. False where nothing of it can be seen: centre not
// beyond near_m, the ellipse off the screen, opacity under 1/255, less than the contribution asked for, or a
// value that is not finite. A centre off the screen does not matter as long as the ellipse reaches in.
bool project_kernel(const Projection& projection, const DrawnObject& object, size_t kernel,
                    uint32_t object_slot, const RasteriseOptions& options, ProjectedKernel& projected,
                    float& order_depth_m);

}  // namespace livegs
