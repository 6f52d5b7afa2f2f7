// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <thread>

#include "patience.h"
#include "scratch_folder.h"
#include "xr/display/video_file.h"
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

// Output of a shell command.
std::string output_of(const std::string& command) {
  std::string text;
  std::FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  ::pclose(pipe);
  return text;
}

// Pictures in a video, and the errors of its reader.
std::string pictures_in(const std::string& video) {
  return output_of("ffprobe -v error -count_frames -show_entries stream=nb_read_frames -of csv=p=0 " + video +
                   " 2>&1");
}

size_t count_in(const std::string& file, const std::string& what) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  const std::string bytes = text.str();
  size_t count = 0;
  for (size_t at = bytes.find(what); at != std::string::npos; at = bytes.find(what, at + 1)) ++count;
  return count;
}

// Five seconds of video; the encoder is killed once two fragments are in the file.
TEST(VideoFile, IsReadableWhenItsWriterWasKilled) {
  const ScratchFolder folder;
  const std::string path = (folder / "killed.mp4").string();
  auto video = VideoFile::create(path, 64, 48, 30);
  if (!video) GTEST_SKIP() << video.error().message;
  for (int k = 0; k < 150; ++k) ASSERT_TRUE(video->add(grey(64, 48, 0.006f * static_cast<float>(k))));
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (count_in(path, "moof") < 2 && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const pid_t encoder = video->process();
  ASSERT_EQ(::kill(encoder, SIGKILL), 0);
  const auto finished = video->finish();
  EXPECT_FALSE(finished);
  const std::string pictures = pictures_in(path);
  EXPECT_GE(std::atoi(pictures.c_str()), 30) << pictures;  // a fragment
  EXPECT_LE(std::atoi(pictures.c_str()), 150) << pictures;
}

TEST(VideoFile, CompleteFileHasItsIndexFirst) {
  const ScratchFolder folder;
  const std::string path = (folder / "complete.mp4").string();
  auto video = VideoFile::create(path, 64, 48, 30);
  if (!video) GTEST_SKIP() << video.error().message;
  for (int k = 0; k < 70; ++k) ASSERT_TRUE(video->add(grey(64, 48, 0.01f * static_cast<float>(k))));
  const auto finished = video->finish();
  EXPECT_TRUE(finished) << finished.error().message;
  EXPECT_EQ(pictures_in(path), "70\n");
  EXPECT_EQ(count_in(path, "moof"), 0u);
  EXPECT_FALSE(std::filesystem::exists(path + ".tmp"));
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
