// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdlib>

#include "scratch_folder.h"
#include "xr/offscreen_display.h"

namespace livegs {
namespace {

Image grey(int width, int height, float value) {
  return {width, height,
          std::vector<float>(4 * static_cast<size_t>(width) * static_cast<size_t>(height), value)};
}

TEST(OffscreenDisplay, ClockCountsPictures) {
  const ScratchFolder folder;
  auto display = OffscreenDisplay::open({folder / "out", 25, 32, 24, 0, false});
  ASSERT_TRUE(display) << display.error().message;
  for (int64_t k = 0; k < 5; ++k) {
    const auto frame = (*display)->wait_frame();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->display_time_ns, k * 40'000'000);
    EXPECT_EQ(frame->views.size(), 1u);
  }
}

TEST(OffscreenDisplay, SavesEveryNthPicture) {
  const ScratchFolder folder;
  auto display = OffscreenDisplay::open({folder / "out", 30, 32, 24, 2, false});
  ASSERT_TRUE(display) << display.error().message;
  for (int k = 0; k < 5; ++k) {
    const std::vector<Image> images = {grey(32, 24, 0.1f * static_cast<float>(k))};
    ASSERT_TRUE((*display)->submit(*(*display)->wait_frame(), images));
  }
  ASSERT_TRUE((*display)->finish());
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(std::filesystem::exists(folder.path() / "out" / ("frame_0000" + std::to_string(k) + ".png")),
              k % 2 == 0);
  }
}

TEST(OffscreenDisplay, PicturesWithoutAFileAreNotKept) {
  const ScratchFolder folder;
  auto some = OffscreenDisplay::open({folder / "some", 30, 32, 24, 2, false});
  auto none = OffscreenDisplay::open({folder / "none", 30, 32, 24, 0, false});
  ASSERT_TRUE(some && none);
  for (int k = 0; k < 4; ++k) {
    EXPECT_EQ((*some)->wait_frame()->kept, k % 2 == 0);
    EXPECT_FALSE((*none)->wait_frame()->kept);
  }
  auto video = OffscreenDisplay::open({folder / "video", 30, 32, 24, 0, true});
  ASSERT_TRUE(video);
  for (int k = 0; k < 4; ++k) EXPECT_TRUE((*video)->wait_frame()->kept);  // also without ffmpeg
}

TEST(OffscreenDisplay, WritesVideoOfOddSize) {
  const ScratchFolder folder;
  auto display = OffscreenDisplay::open({folder / "out", 30, 33, 25, 0, true});
  ASSERT_TRUE(display) << display.error().message;
  if (!(*display)->has_video()) GTEST_SKIP() << "ffmpeg is not installed";
  for (int k = 0; k < 10; ++k) {
    const std::vector<Image> images = {grey(33, 25, 0.1f * static_cast<float>(k))};
    ASSERT_TRUE((*display)->submit(*(*display)->wait_frame(), images));
  }
  const auto finished = (*display)->finish();
  EXPECT_TRUE(finished) << finished.error().message;
  EXPECT_GT(std::filesystem::file_size(folder.path() / "out" / "out.mp4"), 500u);
}

TEST(OffscreenDisplay, SavesPngsWithoutFfmpeg) {
  const ScratchFolder folder;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.path().c_str(), 1);  // an empty folder
  auto display = OffscreenDisplay::open({folder / "out", 30, 32, 24, 30, true});
  ::setenv("PATH", path.c_str(), 1);
  ASSERT_TRUE(display) << display.error().message;
  EXPECT_FALSE((*display)->has_video());
  for (int k = 0; k < 3; ++k) {
    const std::vector<Image> images = {grey(32, 24, 0.5f)};
    ASSERT_TRUE((*display)->submit(*(*display)->wait_frame(), images));
  }
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / "frame_00002.png"));
}

}  // namespace
}  // namespace livegs
