// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/views/transforms_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

Result<std::vector<NamedCamera>> read_text(const std::string& text) {
  const ScratchFolder folder;
  EXPECT_TRUE(write_file_atomically(folder.path() / "transforms.json", text));
  return read_transforms(folder.path() / "transforms.json");
}

constexpr const char* kPose = R"("transform_matrix": [[1,0,0,0.5],[0,1,0,2],[0,0,1,3],[0,0,0,1]])";

TEST(TransformsFile, ReadsIntrinsicsOfTheFileAndOfAFrame) {
  const auto cameras =
      read_text(std::string(R"({"w": 640, "h": 480, "fl_x": 500, "frames": [
      {"file_path": "images/a.b.jpg", )") +
                kPose + R"(}, {"file_path": "c", "w": 320, "h": 240, "camera_angle_x": 1.0, "fl_x": 250, )" +
                kPose + "}]}");
  ASSERT_TRUE(cameras) << cameras.error().message;
  ASSERT_EQ(cameras->size(), 2u);
  EXPECT_EQ((*cameras)[0].name, "a.b");
  EXPECT_EQ((*cameras)[1].name, "c");
  EXPECT_EQ((*cameras)[0].camera.focal_y_px, 500);
  EXPECT_EQ((*cameras)[1].camera.width, 320);
  EXPECT_EQ((*cameras)[1].camera.centre_x_px, 160);
  EXPECT_EQ((*cameras)[0].camera.world_from_camera.position_m, Eigen::Vector3d(0.5, 2, 3));
  EXPECT_EQ(mean_up({(*cameras)[0].camera}), Eigen::Vector3d::UnitY());
}

TEST(TransformsFile, FocalLengthFollowsFromTheAngle) {
  const auto cameras =
      read_text(std::string(R"({"w": 640, "h": 480, "camera_angle_x": 1.2, "frames": [{)") + kPose + "}]}");
  ASSERT_TRUE(cameras);
  EXPECT_DOUBLE_EQ((*cameras)[0].camera.focal_x_px, 320 / std::tan(0.6));
}

TEST(TransformsFile, RefusesWhatIsNoCamera) {
  const char* const wrong[] = {
      "",
      "[]",
      "{\"frames\": []}",
      "{\"frames\": [1]}",
      "{\"frames\": [{}]}",
      "{\"w\": 640, \"h\": 480, \"frames\": [{}]}",
      "{\"w\": -1, \"h\": 480, \"fl_x\": 5, \"frames\": [{}]}",
      "{\"w\": 64, \"h\": 48, \"fl_x\": 5, \"frames\": [{\"transform_matrix\": [[1,0],[2]]}]}",
      "{\"w\": 64, \"h\": 48, \"fl_x\": 5, \"frames\": [{\"transform_matrix\": "
      "[[0,0,0,0],[0,0,0,0],[0,0,0,0]]}]}"};
  for (const char* text : wrong) {
    const auto cameras = read_text(text);
    ASSERT_FALSE(cameras) << text;
    EXPECT_EQ(cameras.error().message.find('\n'), std::string::npos);
    EXPECT_NE(cameras.error().message.find("transforms.json"), std::string::npos) << cameras.error().message;
  }
}

}  // namespace
}  // namespace livegs
