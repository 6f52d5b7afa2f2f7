// SPDX-License-Identifier: Apache-2.0
// Zwicker et al. 2001, EWA splatting, equations 26-31; Kerbl et al. 2023, section 4; the opacity compensation
// is that of Yu et al. 2024, Mip-Splatting, equation 9.
#include "splat/project/project_kernels.h"

#include <algorithm>
#include <cmath>

#include "gaussian/spherical_harmonics.h"

namespace livegs {
namespace {

constexpr double kHalfLog2E = 0.72134752044448170;  // exp(-x/2) = 2^(-kHalfLog2E x)

// The projected covariance xx, xy, yy in px², without the low-pass.
struct ScreenCovariance {
  double xx, xy, yy;
};

ScreenCovariance project_covariance(const Symmetric3f& s, const Eigen::Vector3d& row_x,
                                    const Eigen::Vector3d& row_y) {
  const auto times = [&s](const Eigen::Vector3d& r) {
    return Eigen::Vector3d(s[0] * r.x() + s[1] * r.y() + s[2] * r.z(),
                           s[1] * r.x() + s[3] * r.y() + s[4] * r.z(),
                           s[2] * r.x() + s[4] * r.y() + s[5] * r.z());
  };
  const Eigen::Vector3d across = times(row_x);
  return {across.dot(row_x), across.dot(row_y), times(row_y).dot(row_y)};
}

double deviation_along(const Symmetric3f& s, const Eigen::Vector3d& d) {
  const double variance = s[0] * d.x() * d.x() + s[3] * d.y() * d.y() + s[5] * d.z() * d.z() +
                          2.0 * (s[1] * d.x() * d.y() + s[2] * d.x() * d.z() + s[4] * d.y() * d.z());
  return std::sqrt(std::max(0.0, variance));
}

double sigmoid(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

// Rises from 0 at near_m to 1 at three times near_m.
double near_fade(double depth_m, double near_m) {
  if (near_m <= 0.0) return 1.0;
  return std::min(1.0, (depth_m - near_m) / (2.0 * near_m));
}

}  // namespace

Projection::Projection(const Camera& camera)
    : position_m(camera.world_from_camera.position_m),
      focal_x_px(camera.focal_x_px),
      focal_y_px(camera.focal_y_px),
      centre_x_px(camera.centre_x_px),
      centre_y_px(camera.centre_y_px),
      near_m(std::max(0.0, camera.near_m)),
      width(camera.width),
      height(camera.height) {
  const Eigen::Matrix3d world_from_camera =
      camera.world_from_camera.orientation.normalized().toRotationMatrix();
  image_from_world = Eigen::Vector3d(1, -1, -1).asDiagonal() * world_from_camera.transpose();
  const double beyond_x = 0.15 * width, beyond_y = 0.15 * height;
  min_slope_x = -(centre_x_px + beyond_x) / focal_x_px;
  max_slope_x = (width - centre_x_px + beyond_x) / focal_x_px;
  min_slope_y = -(centre_y_px + beyond_y) / focal_y_px;
  max_slope_y = (height - centre_y_px + beyond_y) / focal_y_px;
}

bool project_kernel(const Projection& projection, const DrawnObject& object, size_t kernel,
                    uint32_t object_slot, const RasteriseOptions& options, ProjectedKernel& projected,
                    float& order_depth_m) {
  const GaussianAsset& asset = *object.asset;
  const PosedKernels& posed = *object.kernels;
  const Eigen::Vector3d offset_m = posed.positions_m[kernel].cast<double>() - projection.position_m;
  const Eigen::Vector3d t = projection.image_from_world * offset_m;
  const double z = t.z();
  if (!(z > projection.near_m)) return false;

  const double slope_x = t.x() / z, slope_y = t.y() / z;
  const double centre_x = projection.focal_x_px * slope_x + projection.centre_x_px;
  const double centre_y = projection.focal_y_px * slope_y + projection.centre_y_px;
  const double held_x = std::clamp(slope_x, projection.min_slope_x, projection.max_slope_x);
  const double held_y = std::clamp(slope_y, projection.min_slope_y, projection.max_slope_y);
  const auto& axes = projection.image_from_world;
  const Eigen::Vector3d row_x =
      (projection.focal_x_px / z) * (axes.row(0) - held_x * axes.row(2)).transpose();
  const Eigen::Vector3d row_y =
      (projection.focal_y_px / z) * (axes.row(1) - held_y * axes.row(2)).transpose();
  ScreenCovariance s = project_covariance(posed.covariances_m2[kernel], row_x, row_y);

  const double sharp_det = std::max(0.0, s.xx * s.yy - s.xy * s.xy);
  // Not (xx + low)(yy + low) - xy²: cancellation there would lose the width of a needle.
  double det = sharp_det + kLowPassPx2 * (s.xx + s.yy) + kLowPassPx2 * kLowPassPx2;
  double xx = s.xx + kLowPassPx2, yy = s.yy + kLowPassPx2;
  if (!(det > 0.0) || !(xx > 0.0) || !(yy > 0.0) || !std::isfinite(det)) return false;

  double opacity = sigmoid(asset.opacity_logits[kernel]) * near_fade(z, projection.near_m);
  if (asset.antialiased) opacity *= std::sqrt(sharp_det / det);
  if (!(opacity >= kMinAlpha)) return false;
  const double log2_opacity = std::log2(opacity);

  const double rim = (log2_opacity + kLog2Of255) / kHalfLog2E;  // dᵀ S⁻¹ d where alpha is kMinAlpha
  const double most = double{options.max_radius_px} * options.max_radius_px;
  // The trace bounds the longest axis; most kernels are far smaller.
  if (options.max_radius_px > 0 && rim * (xx + yy) > 0.99 * most) {
    const double longest = rim * (0.5 * (xx + yy) + std::hypot(0.5 * (xx - yy), s.xy));
    if (longest > most) {
      const double shrink = most / longest;
      xx *= shrink;
      s.xy *= shrink;
      yy *= shrink;
      det *= shrink * shrink;
    }
  }
  if (opacity * 2.0 * M_PI * std::sqrt(det) < options.min_contribution_px) return false;
  const double reach_x = std::sqrt(rim * xx), reach_y = std::sqrt(rim * yy);
  const double left = centre_x - reach_x, right = centre_x + reach_x;
  const double top = centre_y - reach_y, bottom = centre_y + reach_y;
  if (!(right >= 0.0 && left <= projection.width && bottom >= 0.0 && top <= projection.height)) return false;

  const auto tile_at = [](double at, int size) {
    return static_cast<uint32_t>(std::clamp(at, 0.0, size - 1.0)) / kTileSize;
  };
  const uint32_t column = tile_at(left, projection.width), row = tile_at(top, projection.height);
  const uint32_t columns = (static_cast<uint32_t>(projection.width) + kTileSize - 1) / kTileSize;
  const double scale = std::sqrt(kHalfLog2E);
  projected.centre_x_px = static_cast<float>(centre_x);
  projected.centre_y_px = static_cast<float>(centre_y);
  projected.across_x = static_cast<float>(scale * std::sqrt(yy / det));
  projected.across_y = static_cast<float>(-scale * s.xy / std::sqrt(yy * det));
  projected.down_y = static_cast<float>(scale / std::sqrt(yy));
  projected.log2_opacity = static_cast<float>(log2_opacity);
  projected.depth_m = static_cast<float>(z);
  projected.object_slot = object_slot;
  projected.kernel = static_cast<uint32_t>(kernel);
  projected.tile_bound =
      (tile_at(right, projection.width) - column + 1) * (tile_at(bottom, projection.height) - row + 1);
  projected.tile = row * columns + column;
  Eigen::Vector3d towards = axes.row(2).transpose();
  double order_m = z;
  if (options.order == DepthOrder::Distance) {
    towards =
        posed.positions_m[kernel].cast<double>() - options.distance_from_m.value_or(projection.position_m);
    order_m = towards.norm();
    towards /= std::max(order_m, 1e-9);
  }
  if (const float bias = order_bias(object.object_id, options.environments); bias > 0.0f)
    order_m += bias * deviation_along(posed.covariances_m2[kernel], towards);
  order_depth_m = static_cast<float>(order_m);

  const int degree = std::clamp(options.max_sh_degree, 0, std::min(asset.sh_degree, kMaxShDegree));
  const size_t stride = asset.sh_rest_count();
  Eigen::Vector3f direction = Eigen::Vector3f::UnitZ();
  if (degree > 0) {
    direction = (posed.world_from_asset[kernel].conjugate() * offset_m.cast<float>()).normalized();
  }
  const Eigen::Vector3f colour =
      evaluate_sh_colour(asset.sh_dc[kernel], asset.sh_rest.data() + kernel * stride, degree, direction);
  const float light = options.shadows
                          ? shadow_light(options.shadows->words, posed.positions_m[kernel], object.object_id)
                          : 1.0f;
  projected.red = light * colour.x();
  projected.green = light * colour.y();
  projected.blue = light * colour.z();
  return std::isfinite(projected.centre_x_px) && std::isfinite(projected.centre_y_px);
}

}  // namespace livegs
