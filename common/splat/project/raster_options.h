// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "splat/image.h"
#include "splat/shadow_table.h"

// Options and results of the rasteriser (rasterise.h).

namespace livegs {

enum class DepthOrder {
  ViewZ,     // depth along the view axis: matches the reference implementation
  Distance,  // distance from the camera: invariant under head rotation (KHR_gaussian_splatting's default)
};

// Standard deviations of an environment's kernel along the view that are added to its depth in the drawing
// order. Kernels are ordered by their centres, so the wide kernels of a floor that lie nearer to the eye
// would cover objects on it. Like the slope-scaled depth bias of decals, this orders a surface behind objects
// that are within two of its standard deviations. Smaller: the floor covers thin objects. Larger: hidden
// objects are drawn.
inline constexpr float kEnvironmentOrderBias = 2.0f;
// The bias of one object; `environments` has the ids of those that are an environment.
inline float order_bias(uint32_t object_id, std::span<const uint32_t> environments) {
  return std::find(environments.begin(), environments.end(), object_id) == environments.end()
             ? 0.0f
             : kEnvironmentOrderBias;
}

struct RasteriseOptions {
  Eigen::Vector3f background{0, 0, 0};
  DepthOrder order = DepthOrder::ViewZ;
  int max_sh_degree = 3;
  float min_contribution_px = 0;  // as in eye_view (project_splats.h)
  float max_radius_px = 0;        // as in eye_view; 0: no limit
  // Fills the image only; depth_m and object_id are left empty.
  bool image_only = false;
  // origin of Distance order, for a point between two eyes; empty: the camera
  std::optional<Eigen::Vector3d> distance_from_m = {};
  const ShadowTable* shadows = nullptr;     // of the objects; null: none
  std::vector<uint32_t> environments = {};  // object ids, see kEnvironmentOrderBias
};

struct RasterisedView {
  Image image;  // colour over the background; alpha is coverage
  // along the view axis where transmittance first falls under 0.5; infinity if it never does
  std::vector<float> depth_m;
  // object with the largest share of the pixel's opacity; kNoObject if coverage < 0.5
  std::vector<uint32_t> object_id;
};
inline constexpr uint32_t kNoObject = ~0u;

}  // namespace livegs
