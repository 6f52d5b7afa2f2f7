// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/project/projected_kernel.h"
#include "splat/project/raster_options.h"

namespace livegs {

// The camera in the form used by projection: image axes are x right, y down, z forward.
struct Projection {
  explicit Projection(const Camera& camera);

  Eigen::Matrix3d image_from_world;
  Eigen::Vector3d position_m;
  double focal_x_px, focal_y_px, centre_x_px, centre_y_px;
  // Clamping range of the slopes x/z and y/z in the Jacobian: 15 % of the image beyond each edge, separately
  // for each side because a headset's frustum is asymmetric.
  double min_slope_x, max_slope_x, min_slope_y, max_slope_y;
  double near_m;
  int width, height;
};

// Computes the ellipse of one kernel and its sort depth. False if nothing of it is visible: the centre is not
// beyond near_m, the ellipse is off the screen, the opacity is under 1/255, the contribution is below the
// minimum, or a value is not finite. The centre may be off the screen if the ellipse reaches into it.
bool project_kernel(const Projection& projection, const DrawnObject& object, size_t kernel,
                    uint32_t object_slot, const RasteriseOptions& options, ProjectedKernel& projected,
                    float& order_depth_m);

}  // namespace livegs
