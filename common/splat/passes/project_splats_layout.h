// SPDX-License-Identifier: Apache-2.0

// What the pass project_splats reads and writes, for C++ and GLSL alike. Scalars only, so that std430 and C++
// lay the members out in the same way.

#ifdef __cplusplus
#pragma once
#endif
#include "gaussian/asset/posed_kernel_row.h"
#ifdef __cplusplus
namespace livegs {
#endif

// What of a kernel does not move. Its bands above the first lie in a buffer of their own as half floats, two
// a word, coefficient by coefficient, three channels each.
struct KernelLookRow {
  float log2_opacity;
  float dc_red;
  float dc_green;
  float dc_blue;
};

// One eye. image_from_world by rows: image axes are x right, y down, z forward.
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
  float min_slope_x;  // where the Jacobian is held
  float max_slope_x;
  float min_slope_y;
  float max_slope_y;
  float near_m;
  float width_px;
  float height_px;
  float max_radius_px;          // 0: none
  float min_log2_contribution;  // of opacity * 2 pi sqrt(det), in px; kCulled_log2: none
};

// The eyes, and what orders kernels for all of them: depth along `axis` from `origin`, or the distance from
// it.
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

// A kernel as one eye sees it; the root form of ProjectedKernel.
struct SplatRow {
  float centre_x_px;
  float centre_y_px;
  float across_x;
  float across_y;
  float down_y;
  float log2_opacity;  // kCulled_log2 where the eye sees nothing of it; the rest is then 0
  float red;
  float green;
  float blue;
};

struct ProjectSplatsConstants {
  uint kernel_count;
  uint first_kernel;  // where their looks and bands begin
  uint first_posed;   // where their posed rows begin
  uint first_key;     // where the keys of these kernels begin
  uint first_row;     // where their rows begin
  uint sh_degree;     // to evaluate, 0..3
  uint sh_row_words;  // from one kernel's bands to the next's
  uint antialiased;   // 1: opacity makes up for the low-pass
};

const uint kProjectGroup = 128;
const float kCulled_log2 = -1000.0;
const float kSplatLowPass_px2 = 0.3;
const float kSplatLog2Of255 = 7.99435344;
const float kLog2OfTwoPi = 2.65149613;

#ifdef __cplusplus
static_assert(sizeof(KernelLookRow) == 16);
static_assert(sizeof(EyeView) == 100 && sizeof(FrameViews) == 232 && sizeof(SplatRow) == 36);
static_assert(sizeof(ProjectSplatsConstants) == 32);
}  // namespace livegs
#endif
