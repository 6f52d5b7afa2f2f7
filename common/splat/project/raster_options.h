// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "splat/image.h"

// What the stages of the rasteriser (rasterise.h) are given and give.

namespace livegs {

enum class DepthOrder {
  ViewZ,     // along the view axis: parity with the reference implementation
  Distance,  // from the camera: does not change when the head turns (KHR_gaussian_splatting's default)
};

struct RasteriseOptions {
  Eigen::Vector3f background{0, 0, 0};
  DepthOrder order = DepthOrder::ViewZ;
  int max_sh_degree = 3;
  float min_contribution_px = 0;  // as eye_view (project_splats.h) has it
  float max_radius_px = 0;        // as well; 0: none
  std::optional<Eigen::Vector3d> distance_from_m =
      {};  // in Distance order, of a point between two eyes; none: from the camera
};

struct RasterisedView {
  Image image;  // colour over the background; alpha is coverage
  std::vector<float>
      depth_m;  // along the view axis where transmittance first falls under 0.5; infinity where it never does
  std::vector<uint32_t> object_id;  // of the object with the largest share of the pixel's opacity; kNoObject
                                    // where coverage < 0.5
};
inline constexpr uint32_t kNoObject = ~0u;

}  // namespace livegs
