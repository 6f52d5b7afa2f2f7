// SPDX-License-Identifier: Apache-2.0
#include "capture/level.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

#include "capture/picture/picture_file.h"
#include "core/math/rotation_between.h"
#include "core/percentile.h"

namespace livegs {
namespace {

// The right axes span a plane if the second eigenvalue of their mean outer product is at least this; it is
// 0.5 for photos all around a place, 0.03 for photos within 35 degrees.
constexpr double kMinSpan = 0.03;
// Largest numbers of cameras and of points in median_distance.
constexpr size_t kMaxDistanceSamples = 200;

// Right and up of the picture as it was taken, in the world; the sign of right is left open.
struct PictureAxes {
  Eigen::Vector3d right, up;
};
PictureAxes picture_axes(const CapturedView& view) {
  const Camera& camera = view.camera;
  const Eigen::Matrix3d axes = camera.world_from_camera.orientation.toRotationMatrix();
  const auto stored = read_picture_header(view.picture);
  int orientation = stored ? stored->orientation : 1;
  // A pose file with the turned size has the pose of the turned picture.
  if (stored && orientation >= 5 && (stored->width > stored->height) != (camera.width > camera.height))
    orientation = 1;
  switch (orientation) {
    case 3:
    case 4:
      return {axes.col(0), -axes.col(1)};
    case 5:
    case 6:
      return {axes.col(1), -axes.col(0)};
    case 7:
    case 8:
      return {axes.col(1), axes.col(0)};
    default:
      return {axes.col(0), axes.col(1)};
  }
}

}  // namespace

Eigen::Vector3d photo_up(const Capture& capture) {
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const CapturedView& view : capture.views) {
    const PictureAxes axes = picture_axes(view);
    outer += axes.right * axes.right.transpose();
    mean += axes.up;
  }
  outer /= static_cast<double>(capture.views.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(outer);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  if (solver.eigenvalues()[1] >= kMinSpan && normal.dot(mean) != 0)
    return normal.dot(mean) > 0 ? normal : Eigen::Vector3d(-normal);
  return mean.norm() > 0 ? mean.normalized() : Eigen::Vector3d::UnitY();
}

void level_capture(Capture& capture, const Eigen::Vector3d& up) {
  const Eigen::Quaterniond turn = rotation_between(up, Eigen::Vector3d::UnitY());
  for (CapturedView& view : capture.views) {
    Pose& pose = view.camera.world_from_camera;
    pose = {turn * pose.position_m, (turn * pose.orientation).normalized()};
  }
  for (Eigen::Vector3f& point : capture.points) point = (turn * point.cast<double>()).cast<float>();
}

double median_distance(const Capture& capture) {
  const auto step = [](size_t count) { return std::max<size_t>(1, count / kMaxDistanceSamples); };
  std::vector<double> distances;
  for (size_t i = 0; i < capture.views.size(); i += step(capture.views.size())) {
    for (size_t k = 0; k < capture.points.size(); k += step(capture.points.size())) {
      const Eigen::Vector3d& eye = capture.views[i].camera.world_from_camera.position_m;
      distances.push_back((capture.points[k].cast<double>() - eye).norm());
    }
  }
  return distances.empty() ? 0 : median(std::move(distances));
}

}  // namespace livegs
