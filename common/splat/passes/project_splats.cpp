// SPDX-License-Identifier: Apache-2.0
// Zwicker et al. 2001, EWA splatting, equations 26-31; project_kernels.cpp has the same in doubles.
// Determinant by Cauchy-Binet; difference of products by Dekker 1971.
#include "splat/passes/project_splats.h"

#include <algorithm>
#include <cmath>

#include "compute/pass_rows.h"
#include "core/assert.h"
#include "gaussian/spherical_harmonics.h"
#include "project_splats.spv.h"
#include "splat/half_float.h"
#include "splat/passes/key_order.h"
#include "splat/passes/order_depth.h"
#include "splat/passes/sort_keys_layout.h"
#include "splat/project/precise.h"
#include "splat/project/project_kernels.h"
#include "splat/shadow_table.h"

namespace livegs {
namespace {

constexpr float kHalfLog2E_f32 = 0.72134752f;

Row3 cross(const Row3& a, const Row3& b) {
  return {a.y * b.z - b.y * a.z, a.z * b.x - b.z * a.x, a.x * b.y - b.x * a.y};
}

Row3 turned_back(const PosedKernelRow& k, const Row3& v) {
  const Row3 axis{-k.qx, -k.qy, -k.qz};
  const Row3 once = cross(axis, v);
  const Row3 twice{2.0f * once.x, 2.0f * once.y, 2.0f * once.z};
  const Row3 last = cross(axis, twice);
  return {v.x + k.qw * twice.x + last.x, v.y + k.qw * twice.y + last.y, v.z + k.qw * twice.z + last.z};
}

struct Cofactors {
  float xx, xy, xz, yy, yz, zz;
};

Cofactors cofactors(const PosedKernelRow& k) {
  return {product_difference(k.syy_m2, k.szz_m2, k.syz_m2, k.syz_m2),
          product_difference(k.sxz_m2, k.syz_m2, k.sxy_m2, k.szz_m2),
          product_difference(k.sxy_m2, k.syz_m2, k.sxz_m2, k.syy_m2),
          product_difference(k.sxx_m2, k.szz_m2, k.sxz_m2, k.sxz_m2),
          product_difference(k.sxy_m2, k.sxz_m2, k.sxx_m2, k.syz_m2),
          product_difference(k.sxx_m2, k.syy_m2, k.sxy_m2, k.sxy_m2)};
}

Row3 offset_from(const PosedKernelRow& k, float x_m, float y_m, float z_m) {
  return {k.x_m - x_m, k.y_m - y_m, k.z_m - z_m};
}

// CPU function of project() in project_splats.comp.glsl, step by step.
bool project(const EyeView& eye, const PosedKernelRow& k, const Cofactors& c, float kernel_log2_opacity,
             bool antialiased, SplatRow& row) {
  row = {0, 0, 0, 0, 0, kCulled_log2, 0, 0, 0};
  const Row3 offset = offset_from(k, eye.x_m, eye.y_m, eye.z_m);
  const Row3 axis_x{eye.xx, eye.xy, eye.xz}, axis_y{eye.yx, eye.yy, eye.yz}, axis_z{eye.zx, eye.zy, eye.zz};
  const float z = dot(axis_z, offset);
  if (!(z > eye.near_m)) return false;
  const float slope_x = dot(axis_x, offset) / z;
  const float slope_y = dot(axis_y, offset) / z;
  const auto jacobian_row = [&](float focal_px, const Row3& axis, float slope) {
    const float scale = focal_px / z;
    return Row3{scale * (axis.x - slope * axis_z.x), scale * (axis.y - slope * axis_z.y),
                scale * (axis.z - slope * axis_z.z)};
  };
  const Row3 row_x =
      jacobian_row(eye.focal_x_px, axis_x, std::clamp(slope_x, eye.min_slope_x, eye.max_slope_x));
  const Row3 row_y =
      jacobian_row(eye.focal_y_px, axis_y, std::clamp(slope_y, eye.min_slope_y, eye.max_slope_y));

  const Row3 across = spread(k, row_x);
  const float sharp_xx = dot(across, row_x);
  const float sharp_yy = dot(spread(k, row_y), row_y);
  float xy = dot(across, row_y);
  const Row3 n = cross(row_x, row_y);
  const Row3 spread_n{c.xx * n.x + c.xy * n.y + c.xz * n.z, c.xy * n.x + c.yy * n.y + c.yz * n.z,
                      c.xz * n.x + c.yz * n.y + c.zz * n.z};
  const float sharp_det = std::max(0.0f, dot(spread_n, n));
  float det = sharp_det + kSplatLowPass_px2 * (sharp_xx + sharp_yy) + kSplatLowPass_px2 * kSplatLowPass_px2;
  float xx = sharp_xx + kSplatLowPass_px2;
  float yy = sharp_yy + kSplatLowPass_px2;
  if (!(det > 0.0f && det < 1e37f && xx > 0.0f && yy > 0.0f)) return false;

  float log2_opacity = kernel_log2_opacity;
  if (eye.near_m > 0.0f && z < 3.0f * eye.near_m) {
    log2_opacity += log2_of((z - eye.near_m) / (2.0f * eye.near_m));
  }
  if (antialiased) {
    if (!(sharp_det > 0.0f)) return false;
    log2_opacity += 0.5f * log2_of(sharp_det / det);
  }
  if (!(log2_opacity >= -kSplatLog2Of255)) return false;

  const float rim = (log2_opacity + kSplatLog2Of255) / kHalfLog2E_f32;
  if (eye.max_radius_px > 0.0f) {
    const float half_gap = 0.5f * (xx - yy);
    const float longest = rim * (0.5f * (xx + yy) + std::sqrt(half_gap * half_gap + xy * xy));
    const float most = eye.max_radius_px * eye.max_radius_px;
    if (longest > most) {
      const float shrink = most / longest;
      xx *= shrink;
      xy *= shrink;
      yy *= shrink;
      det *= shrink * shrink;
    }
  }
  if (eye.min_log2_contribution > kCulled_log2 &&
      log2_opacity + 0.5f * log2_of(det) + kLog2OfTwoPi < eye.min_log2_contribution) {
    return false;
  }
  const float centre_x = eye.focal_x_px * slope_x + eye.centre_x_px;
  const float centre_y = eye.focal_y_px * slope_y + eye.centre_y_px;
  const float reach_x = std::sqrt(rim * xx);
  const float reach_y = std::sqrt(rim * yy);
  if (!(centre_x + reach_x >= 0.0f && centre_x - reach_x <= eye.width_px && centre_y + reach_y >= 0.0f &&
        centre_y - reach_y <= eye.height_px)) {
    return false;
  }
  const float scale = std::sqrt(kHalfLog2E_f32);
  const float root_yy = std::sqrt(yy);
  const float root_det = std::sqrt(det);
  row.centre_x_px = centre_x;
  row.centre_y_px = centre_y;
  row.across_x = scale * (root_yy / root_det);
  row.across_y = -scale * (xy / (root_yy * root_det));
  row.down_y = scale / root_yy;
  row.log2_opacity = log2_opacity;
  return true;
}

void shade(const EyeView& eye, const PosedKernelRow& k, const KernelLookRow& look, uint32_t degree,
           std::span<const uint32_t> bands_of, float light, SplatRow& row) {
  Eigen::Vector3f rest[15];
  const uint32_t count = (degree + 1) * (degree + 1) - 1;
  for (uint32_t i = 0; i < 3 * count; ++i) {
    rest[i / 3][static_cast<int>(i % 3)] =
        float_of_half(static_cast<uint16_t>(bands_of[i / 2] >> (16 * (i % 2))));
  }
  Eigen::Vector3f direction = Eigen::Vector3f::UnitZ();
  if (degree > 0) {
    const Row3 seen = turned_back(k, offset_from(k, eye.x_m, eye.y_m, eye.z_m));
    direction = Eigen::Vector3f(seen.x, seen.y, seen.z).normalized();
  }
  const Eigen::Vector3f colour = evaluate_sh_colour({look.dc_red, look.dc_green, look.dc_blue}, rest,
                                                    static_cast<int>(degree), direction);
  row.red = light * colour.x();
  row.green = light * colour.y();
  row.blue = light * colour.z();
}

void project_splats(const PassArguments& arguments, size_t begin, size_t end) {
  const auto constants = row_at<ProjectSplatsConstants>(arguments.constants, 0);
  const auto& buffers = arguments.buffers;
  end = std::min<size_t>(end, constants.kernel_count);
  LIVEGS_ASSERT(constants.sh_degree <= kMaxShDegree);
  LIVEGS_ASSERT((constants.first_posed + end) * sizeof(PosedKernelRow) <= buffers[1].size());
  LIVEGS_ASSERT((constants.first_kernel + end) * sizeof(KernelLookRow) <= buffers[2].size());
  LIVEGS_ASSERT((constants.first_row + end) * sizeof(SplatRow) <= buffers[4].size());
  const auto views = row_at<FrameViews>(buffers[0], 0);
  const OrderView order{{views.origin_x_m, views.origin_y_m, views.origin_z_m},
                        {views.axis_x, views.axis_y, views.axis_z},
                        views.by_distance != 0};
  const std::span<const uint32_t> bands = words_of(buffers[3]);
  const std::span<uint32_t> keys = words_of(buffers[6]);
  for (size_t i = begin; i < end; ++i) {
    const auto k = row_at<PosedKernelRow>(buffers[1], constants.first_posed + i);
    const size_t kernel = constants.first_kernel + i;
    const auto look = row_at<KernelLookRow>(buffers[2], kernel);
    const Cofactors c = cofactors(k);
    bool seen = false;
    float light = 1.0f;
    for (uint32_t e = 0; e < views.eye_count; ++e) {
      SplatRow row;
      if (project(views.eye[e], k, c, look.log2_opacity, constants.antialiased != 0, row)) {
        if (!seen) light = shadow_light(words_of(buffers[7]), {k.x_m, k.y_m, k.z_m}, constants.object_id);
        shade(views.eye[e], k, look, constants.sh_degree,
              constants.sh_degree > 0 ? bands.subspan(kernel * constants.sh_row_words) : bands, light, row);
        seen = true;
      }
      set_row(buffers[e == 0 ? 4 : 5], constants.first_row + i, row);
    }
    const float depth = order_depth(order, k, constants.order_bias);
    keys[constants.first_key + i] = seen ? ordered_key(depth) : kSortDroppedKey;
  }
}

}  // namespace

const Pass& project_splats_pass() {
  static const Pass pass{.name = "project_splats",
                         .group_size = kProjectGroup,
                         .buffer_count = 8,
                         .constants_bytes = sizeof(ProjectSplatsConstants),
                         .spirv = project_splats_spirv,
                         .run = project_splats};
  return pass;
}

EyeView eye_view(const Camera& camera, float max_radius_px, float min_contribution_px) {
  const Projection p(camera);
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto& m = p.image_from_world;
  return {.xx = f(m(0, 0)),
          .xy = f(m(0, 1)),
          .xz = f(m(0, 2)),
          .yx = f(m(1, 0)),
          .yy = f(m(1, 1)),
          .yz = f(m(1, 2)),
          .zx = f(m(2, 0)),
          .zy = f(m(2, 1)),
          .zz = f(m(2, 2)),
          .x_m = f(p.position_m.x()),
          .y_m = f(p.position_m.y()),
          .z_m = f(p.position_m.z()),
          .focal_x_px = f(p.focal_x_px),
          .focal_y_px = f(p.focal_y_px),
          .centre_x_px = f(p.centre_x_px),
          .centre_y_px = f(p.centre_y_px),
          .min_slope_x = f(p.min_slope_x),
          .max_slope_x = f(p.max_slope_x),
          .min_slope_y = f(p.min_slope_y),
          .max_slope_y = f(p.max_slope_y),
          .near_m = f(p.near_m),
          .width_px = f(p.width),
          .height_px = f(p.height),
          .max_radius_px = max_radius_px,
          .min_log2_contribution = min_contribution_px > 0 ? std::log2(min_contribution_px) : kCulled_log2};
}

}  // namespace livegs
