// SPDX-License-Identifier: Apache-2.0
#include "capture/level.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

namespace livegs {
namespace {

// The right axes span a plane if the second eigenvalue of their mean outer product is at least this; it is
// 0.5 for photos all around a place, 0.03 for photos within 40 degrees.
constexpr double kMinSpan = 0.03;
// Of cameras and of points in median_distance.
constexpr size_t kMaxDistanceSamples = 200;

}  // namespace

Eigen::Vector3d photo_up(const Capture& capture) {
  Eigen::Matrix3d outer = Eigen::Matrix3d::Zero();
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const CapturedView& view : capture.views) {
    const Eigen::Matrix3d axes = view.camera.world_from_camera.orientation.toRotationMatrix();
    outer += axes.col(0) * axes.col(0).transpose();
    mean += axes.col(1);
  }
  outer /= static_cast<double>(capture.views.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(outer);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  if (solver.eigenvalues()[1] >= kMinSpan && normal.dot(mean) != 0)
    return normal.dot(mean) > 0 ? normal : Eigen::Vector3d(-normal);
  return mean.norm() > 0 ? mean.normalized() : Eigen::Vector3d::UnitY();
}

void level_capture(Capture& capture, const Eigen::Vector3d& up) {
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitY());
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
  if (distances.empty()) return 0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

std::string transforms_text(const Capture& capture) {
  nlohmann::ordered_json file = {{"frames", nlohmann::ordered_json::array()}};
  for (const CapturedView& view : capture.views) {
    const Camera& camera = view.camera;
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix.topLeftCorner<3, 3>() = camera.world_from_camera.orientation.toRotationMatrix();
    matrix.topRightCorner<3, 1>() = camera.world_from_camera.position_m;
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (int row = 0; row < 4; ++row)
      rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
    nlohmann::ordered_json frame = {{"file_path", std::filesystem::absolute(view.picture).string()},
                                    {"transform_matrix", rows},
                                    {"w", camera.width},
                                    {"h", camera.height},
                                    {"fl_x", camera.focal_x_px},
                                    {"fl_y", camera.focal_y_px},
                                    {"cx", camera.centre_x_px},
                                    {"cy", camera.centre_y_px}};
    if (!view.distortion.none()) {
      frame["k1"] = view.distortion.k1;
      frame["k2"] = view.distortion.k2;
      frame["p1"] = view.distortion.p1;
      frame["p2"] = view.distortion.p2;
    }
    if (!view.mask.empty()) frame["mask_path"] = std::filesystem::absolute(view.mask).string();
    file["frames"].push_back(std::move(frame));
  }
  return file.dump(1) + "\n";
}

}  // namespace livegs
