// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scratch_folder.h"
#include "splat/camera_file.h"

namespace livegs {
namespace {

TEST(CameraFile, RoundTrips) {
  const ScratchFolder folder;
  const Camera camera = look_at({1, 2, 3}, {0, 0.5, -1}, {0, 1, 0}, 0.6, 320, 200);
  ASSERT_TRUE(write_camera_file(folder / "camera.json", camera));
  const auto read = read_camera_file(folder / "camera.json", std::nullopt);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->width, 320);
  EXPECT_EQ(read->height, 200);
  EXPECT_NEAR(read->focal_y_px, camera.focal_y_px, 1e-9);
  EXPECT_LT((read->world_from_camera.position_m - camera.world_from_camera.position_m).norm(), 1e-12);
  EXPECT_LT(read->world_from_camera.orientation.angularDistance(camera.world_from_camera.orientation), 1e-7);
}

TEST(CameraFile, AGivenSizeOverridesTheFile) {
  const ScratchFolder folder;
  const auto path =
      folder.write("camera.json", R"({ "position_m": [0,0,2], "look_at_m": [0,0,0], "width": 99 })");
  EXPECT_EQ(read_camera_file(path, std::nullopt)->width, 99);
  EXPECT_EQ(read_camera_file(path, PictureSize{64, 48})->width, 64);
}

TEST(CameraFile, ErrorsContainTheField) {
  const ScratchFolder folder;
  const struct {
    const char* text;
    const char* named;
  } cases[] = {
      {R"({ "look_at_m": [0,0,0] })", "position_m"},
      {R"({ "position_m": [0,0,"NaN"], "look_at_m": [0,0,0] })", "position_m"},
      {R"({ "position_m": [0,0,2], "look_at_m": [0,0,2] })", "look_at_m"},
      {R"({ "position_m": [0,2,0], "look_at_m": [0,0,0] })", "up"},
      {R"({ "position_m": [0,0,2], "look_at_m": [0,0,0], "vertical_fov_deg": 180 })", "vertical_fov_deg"},
      {R"({ "position_m": [0,0,2], "look_at_m": [0,0,0], "width": 0 })", "width"},
      {R"({ "zoom": 2 })", "zoom"},
  };
  for (const auto& one : cases) {
    const auto read = read_camera_file(folder.write("bad.json", one.text), std::nullopt);
    ASSERT_FALSE(read) << one.text;
    EXPECT_NE(read.error().message.find("bad.json"), std::string::npos);
    EXPECT_NE(read.error().message.find(one.named), std::string::npos) << read.error().message;
  }
}

}  // namespace
}  // namespace livegs
