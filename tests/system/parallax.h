// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "gaussian/posed_kernels.h"
#include "render/scene_view.h"
#include "splat/camera.h"
#include "splat/image.h"

namespace livegs {

// Two eyes that look the same way and stand b apart see a point at depth z by b / z apart, as tangents: the left eye further to
// the right. Both eyes of the simulated headset do (openxr_runtime/spaces.cpp).
inline constexpr double kEyesApart_m = 0.064;

// Where an object stands in the pictures of two eyes, by the middles of its kernels.
struct SeenByBothEyes {
  std::array<Eigen::AlignedBox2d, 2> in_picture_px;
  double depth_m = 0;  // along the view axis, of what is seen of it: the harmonic mean over pixels of the nearest in each
};

// Nothing where a part of it is not in both pictures.
inline std::optional<SeenByBothEyes> seen_by_both(const PosedKernels& kernels, std::span<const Camera> eyes) {
  constexpr double kBulge_px = 3;  // of what a kernel blurs over its middle, whole in both pictures or its light would move
  SeenByBothEyes seen;
  double inverse_depths = 0;
  size_t pixels = 0;
  for (size_t e = 0; e < 2; ++e) {
    const Camera& eye = eyes[e];
    const Pose camera_from_world = eye.world_from_camera.inverse();
    std::map<std::pair<int, int>, double> nearest_m;
    for (const Eigen::Vector3f& position_m : kernels.positions_m) {
      const Eigen::Vector3d at = camera_from_world * position_m.cast<double>();
      const double depth_m = -at.z();
      if (depth_m < eye.near_m) return std::nullopt;
      const Eigen::Vector2d pixel(eye.centre_x_px + eye.focal_x_px * at.x() / depth_m, eye.centre_y_px - eye.focal_y_px * at.y() / depth_m);
      seen.in_picture_px[e].extend(pixel);
      double& nearest = nearest_m.emplace(std::pair(static_cast<int>(pixel.x()), static_cast<int>(pixel.y())), depth_m).first->second;
      nearest = std::min(nearest, depth_m);
    }
    for (const auto& [pixel, depth_m] : nearest_m) inverse_depths += 1 / depth_m;
    pixels += nearest_m.size();
    Eigen::AlignedBox2d& box = seen.in_picture_px[e];
    box.min().array() -= kBulge_px;
    box.max().array() += kBulge_px;
    if (!Eigen::AlignedBox2d(Eigen::Vector2d(0, 0), Eigen::Vector2d(eye.width, eye.height)).contains(box)) return std::nullopt;
  }
  if (pixels == 0) return std::nullopt;
  seen.depth_m = static_cast<double>(pixels) / inverse_depths;
  return seen;
}

// Whether any of it is before an eye, in its picture or not.
inline bool is_before(const PosedKernels& kernels, std::span<const Camera> eyes) {
  for (const Camera& eye : eyes) {
    const Pose camera_from_world = eye.world_from_camera.inverse();
    for (const Eigen::Vector3f& position_m : kernels.positions_m) {
      if ((camera_from_world * position_m.cast<double>()).z() < 0) return true;
    }
  }
  return false;
}

// Where the light of a part of a picture lies, as the tangent of the angle to the right of the view axis; nothing where there is none.
inline std::optional<double> light_tangent(const Image& image, const Camera& eye, const Eigen::AlignedBox2d& within_px) {
  double sum = 0, weight = 0;
  for (int y = std::max(0, static_cast<int>(within_px.min().y())); y < std::min(1.0 * image.height, within_px.max().y()); ++y) {
    for (int x = std::max(0, static_cast<int>(within_px.min().x())); x < std::min(1.0 * image.width, within_px.max().x()); ++x) {
      double light = 0;
      for (int c = 0; c < 3; ++c) light += std::abs(image.at(x, y)[c] - kBackground[c]);
      if (light < 0.1) continue;
      sum += light * (x + 0.5 - eye.centre_x_px) / eye.focal_x_px;
      weight += light;
    }
  }
  return weight > 0 ? std::optional(sum / weight) : std::nullopt;
}

// How much further to the right the left eye's picture has the object's light than the right eye's, as a tangent.
inline std::optional<double> parallax(const Image& left, const Image& right, std::span<const Camera> eyes, const SeenByBothEyes& seen) {
  const auto l = light_tangent(left, eyes[0], seen.in_picture_px[0]), r = light_tangent(right, eyes[1], seen.in_picture_px[1]);
  return l && r ? std::optional(*l - *r) : std::nullopt;
}

}  // namespace livegs
