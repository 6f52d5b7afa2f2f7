// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"
#include "render/scene_view.h"
#include "splat/camera.h"
#include "splat/image.h"

namespace livegs {

// Two parallel eyes at distance b see a point at depth z with a parallax of b / z, as a difference of
// tangents; the left eye sees it further to the right. The eyes of the simulated headset are parallel
// (openxr_runtime/spaces.cpp).
//
// For a box this does not hold exactly, because the eyes see different parts of its sides. With uniform
// brightness, the centroid moves like the middle of the two outline edges. For a box seen from a corner, with
// edges at 0.94 and 1.06 m, this is 1.004 b, whereas the mean of b / z over the visible surface would be up
// to 1.06 b. Therefore the light of each face is computed as each eye sees it.
inline constexpr double kEyesApart_m = 0.064;

// A face of a box: kernels in one plane.
struct BoxFace {
  Eigen::Vector3d normal, middle_m;
  double light = 0;  // difference of its colour from the background
  std::vector<Eigen::Vector3d> points_m;
};

inline double light_of(const Eigen::Vector3f& colour) {
  return (colour.cwiseMax(0.0f).cwiseMin(1.0f) - kBackground).cwiseAbs().sum();
}

// Requires kernels of one colour per face, as shape_asset.h in server/scene creates.
inline std::vector<BoxFace> faces_of_box(const DrawnObject& box) {
  constexpr float kShDc = 0.28209479f;
  constexpr double kSamePlane_m = 0.005;
  std::vector<BoxFace> faces;
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < box.kernels->positions_m.size(); ++i) {
    const Symmetric3f& s = box.kernels->covariances_m2[i];
    Eigen::Matrix3d covariance;
    covariance << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
    const Eigen::Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance)
                                       .eigenvectors()
                                       .col(0);  // the shortest axis
    const Eigen::Vector3d at_m = box.kernels->positions_m[i].cast<double>();
    const auto same = [&](const BoxFace& face) {
      return std::abs(face.normal.dot(normal)) > 0.99 &&
             std::abs(face.normal.dot(at_m - face.points_m.front())) < kSamePlane_m;
    };
    auto face = std::find_if(faces.begin(), faces.end(), same);
    if (face == faces.end()) {
      const Eigen::Vector3f colour = (0.5f + kShDc * box.asset->sh_dc[i].array()).matrix();
      face = faces.insert(faces.end(), {normal, Eigen::Vector3d::Zero(), light_of(colour), {}});
    }
    face->points_m.push_back(at_m);
    middle_m += at_m / static_cast<double>(box.kernels->positions_m.size());
  }
  for (BoxFace& face : faces) {
    for (const Eigen::Vector3d& point_m : face.points_m)
      face.middle_m += point_m / static_cast<double>(face.points_m.size());
    if (face.normal.dot(face.middle_m - middle_m) < 0) face.normal = -face.normal;
  }
  return faces;
}

// Area and centroid of the convex hull of points (Andrew 1979, and the shoelace formula).
struct Outline {
  double area = 0;
  Eigen::Vector2d middle{0, 0};
};
inline Outline outline_of(std::vector<Eigen::Vector2d> points) {
  const auto cross = [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return a.x() * b.y() - a.y() * b.x();
  };
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  std::vector<Eigen::Vector2d> hull;
  for (int half = 0; half < 2; ++half) {
    const size_t begun = hull.size();
    for (const Eigen::Vector2d& point : points) {
      while (hull.size() >= begun + 2 && cross(hull.back() - hull[hull.size() - 2], point - hull.back()) <= 0)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  Outline outline;
  for (size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d &a = hull[i], &b = hull[(i + 1) % hull.size()];
    outline.area += 0.5 * cross(a, b);
    outline.middle += cross(a, b) / 6 * (a + b);
  }
  if (outline.area > 0) outline.middle /= outline.area;
  return outline;
}

// Centroid of a box's light for one eye, as tangents of the angles from the view axis, right and up. Empty if
// no face is visible.
inline std::optional<Eigen::Vector2d> light_of_faces(std::span<const BoxFace> faces, const Camera& eye) {
  const Pose camera_from_world = eye.world_from_camera.inverse();
  Eigen::Vector2d sum(0, 0);
  double weight = 0;
  for (const BoxFace& face : faces) {
    if (face.normal.dot(eye.world_from_camera.position_m - face.middle_m) <= 0) continue;
    std::vector<Eigen::Vector2d> tangents;
    for (const Eigen::Vector3d& point_m : face.points_m) {
      const Eigen::Vector3d at = camera_from_world * point_m;
      tangents.push_back(at.head<2>() / -at.z());
    }
    const Outline outline = outline_of(std::move(tangents));
    sum += face.light * outline.area * outline.middle;
    weight += face.light * outline.area;
  }
  return weight > 0 ? std::optional<Eigen::Vector2d>(sum / weight) : std::nullopt;
}

// A box in the pictures of two eyes, computed from its kernel centres.
struct SeenByBothEyes {
  std::array<Eigen::AlignedBox2d, 2> in_picture_px;
  double parallax = 0;  // expected shift of the left eye's light to the right, as a tangent
};

// Empty if a part of the box is outside one of the pictures.
inline std::optional<SeenByBothEyes> seen_by_both(const DrawnObject& box, std::span<const Camera> eyes) {
  constexpr double kBulge_px =
      3;  // standard deviations of a kernel that must be inside both pictures, so that its light is complete
  SeenByBothEyes seen;
  for (size_t e = 0; e < 2; ++e) {
    const Camera& eye = eyes[e];
    const Pose camera_from_world = eye.world_from_camera.inverse();
    for (const Eigen::Vector3f& position_m : box.kernels->positions_m) {
      const Eigen::Vector3d at = camera_from_world * position_m.cast<double>();
      const double depth_m = -at.z();
      if (depth_m < eye.near_m) return std::nullopt;
      seen.in_picture_px[e].extend(Eigen::Vector2d(eye.centre_x_px + eye.focal_x_px * at.x() / depth_m,
                                                   eye.centre_y_px - eye.focal_y_px * at.y() / depth_m));
    }
    Eigen::AlignedBox2d& within = seen.in_picture_px[e];
    within.min().array() -= kBulge_px;
    within.max().array() += kBulge_px;
    if (!Eigen::AlignedBox2d(Eigen::Vector2d(0, 0), Eigen::Vector2d(eye.width, eye.height)).contains(within))
      return std::nullopt;
  }
  const std::vector<BoxFace> faces = faces_of_box(box);
  const auto left = light_of_faces(faces, eyes[0]), right = light_of_faces(faces, eyes[1]);
  if (!left || !right) return std::nullopt;
  seen.parallax = left->x() - right->x();
  return seen;
}

// True if any kernel is in front of an eye, inside its picture or not.
inline bool is_before(const PosedKernels& kernels, std::span<const Camera> eyes) {
  for (const Camera& eye : eyes) {
    const Pose camera_from_world = eye.world_from_camera.inverse();
    for (const Eigen::Vector3f& position_m : kernels.positions_m) {
      if ((camera_from_world * position_m.cast<double>()).z() < 0) return true;
    }
  }
  return false;
}

// Centroid of the light in a part of a picture, as the tangent of the angle to the right of the view axis.
// Empty if there is no light.
inline std::optional<double> light_tangent(const Image& image, const Camera& eye,
                                           const Eigen::AlignedBox2d& within_px) {
  double sum = 0, weight = 0;
  for (int y = std::max(0, static_cast<int>(within_px.min().y()));
       y < std::min(1.0 * image.height, within_px.max().y()); ++y) {
    for (int x = std::max(0, static_cast<int>(within_px.min().x()));
         x < std::min(1.0 * image.width, within_px.max().x()); ++x) {
      const float* pixel = image.at(x, y);
      const double light = light_of({pixel[0], pixel[1], pixel[2]});
      if (light < 0.1) continue;
      sum += light * (x + 0.5 - eye.centre_x_px) / eye.focal_x_px;
      weight += light;
    }
  }
  return weight > 0 ? std::optional(sum / weight) : std::nullopt;
}

// Shift of the object's light to the right in the left eye's picture relative to the right eye's, as a
// tangent.
inline std::optional<double> parallax(const Image& left, const Image& right, std::span<const Camera> eyes,
                                      const SeenByBothEyes& seen) {
  const auto l = light_tangent(left, eyes[0], seen.in_picture_px[0]),
             r = light_tangent(right, eyes[1], seen.in_picture_px[1]);
  return l && r ? std::optional(*l - *r) : std::nullopt;
}

}  // namespace livegs
