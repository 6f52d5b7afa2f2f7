// SPDX-License-Identifier: Apache-2.0
#include "capture/level.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/capture/picture/jpeg_bytes.h"
#include "core/file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

constexpr double kDegree = M_PI / 180;

// Level photos of the origin from `turn_deg` around it, 40 degrees down, in a frame that is turned by
// `frame`.
Capture photos_around(double turn_deg, const Eigen::Quaterniond& frame) {
  Capture capture;
  for (int i = 0; i < 12; ++i) {
    const double turn = turn_deg * kDegree * i / 12;
    const Eigen::Vector3d eye(std::sin(turn), std::tan(40 * kDegree), std::cos(turn));
    CapturedView view;
    view.camera = look_at(eye, {0, 0, 0}, {0, 1, 0}, 0.8, 40, 30);
    view.camera.world_from_camera = Pose{Eigen::Vector3d::Zero(), frame} * view.camera.world_from_camera;
    capture.views.push_back(view);
  }
  return capture;
}

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

TEST(Level, FindsTheVerticalOfLevelPhotos) {
  const Eigen::Quaterniond frame(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()));
  const Eigen::Vector3d vertical = frame * Eigen::Vector3d::UnitY();
  // The mean up axis of a third of a circle leans by up to 40 degrees.
  for (double turn_deg : {360.0, 120.0, 60.0})
    EXPECT_LT(angle_deg(photo_up(photos_around(turn_deg, frame)), vertical), 1e-6) << turn_deg;
  // Photos from one place tell no more than their own up axis.
  EXPECT_NEAR(angle_deg(photo_up(photos_around(1, frame)), vertical), 40, 0.1);
}

TEST(Level, TurnsPosesAndPoints) {
  const Eigen::Quaterniond frame(Eigen::AngleAxisd(2.0, Eigen::Vector3d(1, 2, 3).normalized()));
  Capture capture = photos_around(360, frame);
  capture.points.push_back((frame * Eigen::Vector3d(0, 0.5, 0)).cast<float>());
  level_capture(capture, photo_up(capture));
  EXPECT_LT(angle_deg(photo_up(capture), Eigen::Vector3d::UnitY()), 1e-6);
  EXPECT_LT((capture.points[0] - Eigen::Vector3f(0, 0.5f, 0)).norm(), 1e-6f);
  const double eye_m = 1 / std::cos(40 * kDegree), height_m = std::tan(40 * kDegree) - 0.5;
  EXPECT_NEAR(median_distance(capture), std::hypot(1.0, height_m), 1e-6);
  for (const CapturedView& view : capture.views)
    EXPECT_NEAR(view.camera.world_from_camera.position_m.norm(), eye_m, 1e-9);
}

// A telephone held upright stores a lying picture; the pose is that of the stored one.
TEST(Level, CountsPhotosAsTheyWereTaken) {
  ScratchFolder folder;
  const Image stored{40, 30, std::vector<float>(4 * 40 * 30, 0.5f)};
  // Turn of the stored picture about the view axis, counter-clockwise, by its EXIF orientation.
  for (const auto& [orientation, turn_deg] :
       {std::pair(1, 0), std::pair(3, 180), std::pair(6, -90), std::pair(8, 90)}) {
    Capture capture = photos_around(360, Eigen::Quaterniond::Identity());
    for (CapturedView& view : capture.views) {
      view.picture = folder / "photo.jpg";
      Pose& pose = view.camera.world_from_camera;
      pose.orientation = pose.orientation * Eigen::AngleAxisd(turn_deg * kDegree, Eigen::Vector3d::UnitZ());
    }
    ASSERT_TRUE(write_file_atomically(folder / "photo.jpg", encode_jpeg(stored, orientation)));
    EXPECT_LT(angle_deg(photo_up(capture), Eigen::Vector3d::UnitY()), 1e-6) << orientation;
  }
}

}  // namespace
}  // namespace livegs
