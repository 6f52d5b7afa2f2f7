// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/views/room_view.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/parallel_for.h"

namespace livegs {
namespace {

// A difference of depth between neighbouring pixels above this, in footprints, is a jump. A plane seen at 7
// degrees has 8.
constexpr double kJump_footprints = 8.0;

}  // namespace

PosedKernels pose_in_place(const GaussianAsset& asset) {
  PosedKernels posed;
  posed.resize(asset.size());
  parallel_for(asset.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      posed.positions_m[i] = asset.positions[i];
      posed.world_from_asset[i] = Eigen::Quaternionf::Identity();
      const Eigen::Matrix3d axes = asset.rotations[i].cast<double>().toRotationMatrix() *
                                   asset.log_scales[i].cast<double>().array().exp().matrix().asDiagonal();
      const Eigen::Matrix3d s = axes * axes.transpose();
      posed.covariances_m2[i] = {static_cast<float>(s(0, 0)), static_cast<float>(s(0, 1)),
                                 static_cast<float>(s(0, 2)), static_cast<float>(s(1, 1)),
                                 static_cast<float>(s(1, 2)), static_cast<float>(s(2, 2))};
    }
  });
  return posed;
}

Eigen::Vector3d ViewRays::point_m(int x, int y, double depth_m) const {
  const Eigen::Vector3d in_image((x + 0.5 - projection_.centre_x_px) / projection_.focal_x_px * depth_m,
                                 (y + 0.5 - projection_.centre_y_px) / projection_.focal_y_px * depth_m,
                                 depth_m);
  return world_from_image_ * in_image + projection_.position_m;
}

bool ViewRays::project(const Eigen::Vector3d& point_m, Hit& hit) const {
  const Eigen::Vector3d t = projection_.image_from_world * (point_m - projection_.position_m);
  if (!(t.z() > projection_.near_m)) return false;
  const double x = projection_.focal_x_px * t.x() / t.z() + projection_.centre_x_px;
  const double y = projection_.focal_y_px * t.y() / t.z() + projection_.centre_y_px;
  if (!(x >= 0 && y >= 0 && x < projection_.width && y < projection_.height)) return false;
  hit = {static_cast<int>(x), static_cast<int>(y), t.z()};
  return true;
}

Eigen::Vector3f pixel_normal(const ViewRays& rays, const KernelView& view, int x, int y) {
  const auto depth = [&](int px, int py) {
    return static_cast<double>(view.depth_m[static_cast<size_t>(py) * view.width + px]);
  };
  const double here = depth(x, y), jump_m = kJump_footprints * rays.footprint_m(here);
  // The difference over two pixels, or over one at the rim of the picture or at a jump.
  const auto slope = [&](int dx, int dy) -> Eigen::Vector3d {
    const auto usable = [&](int sign) {
      const int px = x + sign * dx, py = y + sign * dy;
      return px >= 0 && py >= 0 && px < view.width && py < view.height &&
             std::abs(depth(px, py) - here) < jump_m;
    };
    const int after = usable(1) ? 1 : 0, before = usable(-1) ? -1 : 0;
    if (after == before) return Eigen::Vector3d::Zero();
    return rays.point_m(x + after * dx, y + after * dy, depth(x + after * dx, y + after * dy)) -
           rays.point_m(x + before * dx, y + before * dy, depth(x + before * dx, y + before * dy));
  };
  const Eigen::Vector3d normal = slope(0, 1).cross(slope(1, 0));
  if (!(normal.norm() > 0) || !normal.allFinite()) return Eigen::Vector3f::Zero();
  return normal.normalized().cast<float>();
}

std::vector<ViewPoint> view_points(std::span<const RoomView> views, int stride) {
  std::vector<std::vector<ViewPoint>> of_view(views.size());
  parallel_for(views.size(), 1, [&](size_t v, size_t) {
    const KernelView& view = views[v].kernels;
    const ViewRays rays(views[v].camera);
    for (int y = stride / 2; y < view.height; y += stride) {
      for (int x = stride / 2; x < view.width; x += stride) {
        const size_t pixel = static_cast<size_t>(y) * view.width + x;
        const double depth_m = view.depth_m[pixel];
        if (!std::isfinite(depth_m)) continue;
        ViewPoint point;
        point.position_m = rays.point_m(x, y, depth_m).cast<float>();
        point.normal = pixel_normal(rays, view, x, y);
        const float* rgba = view.image.at(x, y);
        point.rgb = Eigen::Vector3f(rgba[0], rgba[1], rgba[2]) / std::max(rgba[3], 0.5f);
        point.view = static_cast<uint32_t>(v);
        point.pixel = static_cast<uint32_t>(pixel);
        point.footprint_m = static_cast<float>(rays.footprint_m(depth_m));
        of_view[v].push_back(point);
      }
    }
  });
  std::vector<ViewPoint> points;
  for (const auto& some : of_view) points.insert(points.end(), some.begin(), some.end());
  return points;
}

}  // namespace livegs
