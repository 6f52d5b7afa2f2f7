// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

#include "train/loss/shape_loss.h"

namespace livegs {

// Settings of a training run. The defaults of the rates are those of Kerbl et al. 2023; intervals are shares
// of the number of steps, so that short runs pass through the same phases as long ones.
struct TrainOptions {
  size_t steps = 7000;          // one photo each
  size_t max_kernels = 30'000;  // densification stops there
  int longest_px = 640;         // longest edge of the photos in training; larger photos are reduced
  uint64_t seed = 1;
  ShapeOptions shape;
  // Weight of the mean spread of depths along a ray, as a share of the extent. It contracts the kernels on a
  // ray to one depth. Without it, half-transparent surfaces with others far behind them fit the photos as
  // well.
  double spread_weight = 0.2;
  // Change of colour per pixel (root of the sum of squares) at which a pixel of the photo has half of that
  // weight. Texture already determines the depth of a surface, and at the edge of an object two depths are
  // correct.
  double spread_edge = 0.02;
  // Error of a pixel (root of the sum of squares) at which it has half of that weight. The loss chooses among
  // kernels that meet the photo. Elsewhere it would keep kernels in front of a surface that they hide,
  // because opaque kernels have no spread.
  double spread_error = 0.05;
  bool ignore_masked = false;                      // ignores pixels whose mask is 0
  uint64_t max_picture_bytes = uint64_t{1} << 30;  // of photos in memory

  // Learning rates per step of a run of kFullSteps. Shorter runs multiply them by the square root of
  // kFullSteps / steps, at most kMaxRateFactor, because a kernel has fewer steps to move, turn and shrink.
  // Positions: times the extent of the scene, falling exponentially.
  double position_rate = 1.6e-4, last_position_rate = 1.6e-6;
  double scale_rate = 5e-3, rotation_rate = 1e-3, opacity_rate = 2.5e-2;
  double colour_rate = 2.5e-3, harmonics_rate = 1.25e-4;
  // All other rates fall to this share over the second half of the steps, which averages the views at the
  // end.
  double last_rate_share = 0.1;

  // Densification from and until these shares of the steps.
  double grow_from = 0.05, grow_until = 0.83;
  // Colour depends on the direction of view up to degree 1 after this share of the steps, 2 after two, 3
  // after three.
  double harmonics_interval = 0.125;
  // Corrects the poses of the cameras by the gradient of the loss, after `poses_from` of the steps. In a step
  // of its photo, a position moves by about pose_rate times the extent and an orientation by about pose_rate
  // in rad; both fall exponentially to `last_pose_share` at the end. Held-out photos get their poses from the
  // finished kernels. Exact poses get slightly worse by it.
  bool refine_poses = false;
  double poses_from = 0.05, pose_rate = 1e-4, last_pose_share = 0.01;

  // Smallest standard deviation of a kernel along any axis, as a share of a pixel of the nearest camera.
  // Thinner kernels give the same picture, but rounding destroys their depth.
  double min_axis_px = 0.1;
};

inline constexpr double kFullSteps = 30'000, kMaxRateFactor = 8;

// Limits of the options.
inline constexpr size_t kMaxTrainSteps = 1'000'000;
inline constexpr size_t kMaxTrainedKernels = 10'000'000;

}  // namespace livegs
