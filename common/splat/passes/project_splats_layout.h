// SPDX-License-Identifier: Apache-2.0

// Data of the pass project_splats. Shared by C++ and GLSL. Members are scalars, so std430 and C++ have the
// same layout.

#ifdef __cplusplus
#pragma once
#endif
#include "gaussian/asset/posed_kernel_row.h"
#ifdef __cplusplus
namespace livegs {
#endif

// Constant appearance of a kernel. Its bands above the first are in a separate buffer as half floats, two per
// word, coefficient by coefficient, three channels each.
struct KernelLookRow {
  float log2_opacity;
  float dc_red;
  float dc_green;
  float dc_blue;
};

// One eye. image_from_world by rows; image axes are x right, y down, z forward.
struct EyeView {
  float xx;
  float xy;
  float xz;
  float yx;
  float yy;
  float yz;
  float zx;
  float zy;
  float zz;
  float x_m;
  float y_m;
  float z_m;
  float focal_x_px;
  float focal_y_px;
  float centre_x_px;
  float centre_y_px;
  float min_slope_x;  // clamping range of the Jacobian
  float max_slope_x;
  float min_slope_y;
  float max_slope_y;
  float near_m;
  float width_px;
  float height_px;
  float max_radius_px;          // 0: no limit
  float min_log2_contribution;  // of opacity * 2 pi sqrt(det), in px; kCulled_log2: no limit
};

// The eyes, and the sort key of kernels for both: depth along `axis` from `origin`, or distance from it.
struct FrameViews {
  EyeView eye[2];
  float origin_x_m;
  float origin_y_m;
  float origin_z_m;
  float axis_x;
  float axis_y;
  float axis_z;
  uint eye_count;    // 1 or 2
  uint by_distance;  // 1: distance; 0: depth along the axis
};

// A kernel projected for one eye; the root form of ProjectedKernel.
struct SplatRow {
  float centre_x_px;
  float centre_y_px;
  float across_x;
  float across_y;
  float down_y;
  float log2_opacity;  // kCulled_log2 if the eye does not see the kernel; the rest is then 0
  float red;
  float green;
  float blue;
};

struct ProjectSplatsConstants {
  uint kernel_count;
  uint first_kernel;  // start of their looks and bands
  uint first_posed;   // start of their posed rows
  uint first_key;     // start of their keys
  uint first_row;     // start of their rows
  uint sh_degree;     // degree to evaluate, 0..3
  uint sh_row_words;  // words per kernel in the bands buffer
  uint antialiased;   // 1: opacity compensates for the low-pass
  uint object_id;     // of the kernels, which its own shadow does not darken
  float order_bias;   // kEnvironmentOrderBias for an environment, else 0
};

const uint kProjectGroup = 128;
const float kCulled_log2 = -1000.0;
const float kSplatLowPass_px2 = 0.3;
const float kSplatLog2Of255 = 7.99435344;
const float kLog2OfTwoPi = 2.65149613;

#ifdef __cplusplus
static_assert(sizeof(KernelLookRow) == 16);
static_assert(sizeof(EyeView) == 100 && sizeof(FrameViews) == 232 && sizeof(SplatRow) == 36);
static_assert(sizeof(ProjectSplatsConstants) == 40);
}  // namespace livegs
#endif
