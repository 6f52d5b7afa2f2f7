// SPDX-License-Identifier: Apache-2.0
// The desktop window on a display that nobody looks at (Xvfb): screenshots before, during and after a pull.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>

#include "core/file.h"
#include "splat/image.h"
#include "system/programs_fixture.h"
#include "system/screen.h"

namespace livegs {
namespace {

class Window : public Programs {
 protected:
  std::string size_ = "1280x800";
  std::vector<std::string> window_words(const std::string& display, const std::string& port,
                                        std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"/usr/bin/env", "DISPLAY=" + display, LIVEGS_CLIENT, "127.0.0.1:" + port,
                                      "--display",    "window",             "--size",      size_,
                                      "--cache",      folder_ / "cache",    "--threads",   "2"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

// A server, and a display to open a window on. Skips where there is no Xvfb (deploy/packages.txt has it).
class WindowOnADisplay : public Window {
 protected:
  void SetUp() override {
    if (!Screen::there_is_one()) GTEST_SKIP() << "no Xvfb; install xvfb";
    screen_ = std::make_unique<Screen>();
    display_ = screen_->display;
    ASSERT_NE(display_, "") << screen_->program->err();
    server_ = std::make_unique<Program>(server_words());
    port_ = server_->first_line();
    ASSERT_NE(port_, "") << server_->err();
  }
  std::unique_ptr<Screen> screen_;
  std::unique_ptr<Program> server_;
  std::string display_, port_;
};

// Between the panels.
constexpr int kLeft = 315, kRight = 875;

// Pixels there that differ by more than a twentieth.
size_t changed(const Image& a, const Image& b) {
  size_t count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = kLeft; x < kRight; ++x) {
      double most = 0;
      for (int c = 0; c < 3; ++c) most = std::max<double>(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      count += most > 0.05;
    }
  }
  return count;
}

// Pixels there in the very colour of a force.
size_t force_pixels(const Image& image) {
  size_t count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = kLeft; x < kRight; ++x) {
      const float* pixel = image.at(x, y);
      count += std::abs(pixel[0] - 1.0f) < 0.01f && std::abs(pixel[1] - 150 / 255.0f) < 0.01f &&
               std::abs(pixel[2] - 30 / 255.0f) < 0.01f;
    }
  }
  return count;
}

// Pixels of a part of the picture that are as bright as a panel's text.
size_t text_pixels(const Image& image, int left, int right, int top, int bottom) {
  size_t count = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const float* pixel = image.at(x, y);
      count += pixel[0] > 0.55f && pixel[1] > 0.55f && pixel[2] > 0.55f;
    }
  }
  return count;
}

// One by one: a picture takes 16 MB.
size_t read_shots(const std::filesystem::path& folder, const std::function<void(const Image&)>& see) {
  for (size_t i = 0;; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "window_%03zu.png", i);
    const auto image = read_png(folder / name);
    if (!image) return i;
    see(*image);
  }
}

// Before, during and after a pull.
TEST_F(WindowOnADisplay, ShowsTheSceneAndAPull) {
  const std::string shots = folder_ / "shots";
  // The box between the panels.
  const std::string camera = folder_.write("camera.json", R"({ "position_m": [-0.3, 0.4, 1.8], "look_at_m": [-0.3, 0.3, 0],
                                                              "vertical_fov_deg": 40 })");
  Program window(window_words(display_, port_, {"--seconds", "5", "--poke", "box", "--output", shots, "--every", "1",
                                                "--renderer", "cpu", "--camera", camera}));
  EXPECT_EQ(window.wait(), 0) << window.err();

  // The box is drawn up, and an arrow that is seen stands at it while it is pulled, neither before nor after.
  Image before;
  size_t most_changed = 0, most_force = 0, last_force = 0;
  const size_t count = read_shots(shots, [&](const Image& image) {
    if (before.pixels.empty()) before = image;
    most_changed = std::max(most_changed, changed(before, image));
    last_force = force_pixels(image);
    most_force = std::max(most_force, last_force);
  });
  ASSERT_GE(count, 3u) << window.err();
  ASSERT_EQ(before.width, 1280);
  ASSERT_EQ(before.height, 800);
  const auto [darkest, brightest] = std::minmax_element(before.pixels.begin(), before.pixels.end());
  EXPECT_GT(*brightest - *darkest, 0.5f);
  EXPECT_GT(most_changed, 2000u);
  EXPECT_EQ(force_pixels(before), 0u);
  EXPECT_GT(most_force, 200u);
  EXPECT_EQ(last_force, 0u);

  server_->send(SIGTERM);
  EXPECT_EQ(server_->wait(), 0) << server_->err();
}

// The panel of an object: text from top to bottom on the right, none of it beyond the panel.
TEST_F(WindowOnADisplay, ShowsWhatAThingIsMadeOf) {
  const std::string plain = folder_ / "plain", selected = folder_ / "selected";
  Program without(window_words(display_, port_, {"--seconds", "3", "--output", plain}));
  EXPECT_EQ(without.wait(), 0) << without.err();
  Program with(window_words(display_, port_, {"--seconds", "3", "--select", "cube", "--output", selected}));
  EXPECT_EQ(with.wait(), 0) << with.err();
  Image closed, open;
  ASSERT_GT(read_shots(plain, [&](const Image& image) { closed = image; }), 0u);
  ASSERT_GT(read_shots(selected, [&](const Image& image) { open = image; }), 0u);
  EXPECT_GT(text_pixels(open, 880, 1270, 120, 790), text_pixels(closed, 880, 1270, 120, 790) + 2000);
  EXPECT_EQ(text_pixels(open, 1271, 1280, 0, 800), 0u);
  EXPECT_GT(text_pixels(open, 10, 310, 10, 400), 1000u);  // the other panel
}

// The elastic study: a force of a size, in a direction, at a point, for a time, as a video with its sentence.
TEST_F(WindowOnADisplay, RecordsAForceWithItsSentence) {
  if (!std::filesystem::exists("/usr/bin/ffmpeg")) GTEST_SKIP() << "no ffmpeg";
  size_ = "480x300";
  const std::filesystem::path study = folder_ / "study";
  Program window(window_words(display_, port_, {"--force", "cube:0,0.1,0:10,0,0:0.3", "--output", study.string()}));
  EXPECT_EQ(window.wait(), 0) << window.err();
  const auto sentence = read_file(study / "study_001.txt");
  ASSERT_TRUE(sentence) << window.err();
  EXPECT_EQ(std::string(reinterpret_cast<const char*>(sentence->data()), sentence->size()),
            "Apply a force of 10 N to the cube for 0.3 s.\n");
  for (const char* name : {"study_001.mp4", "study_001.json", "study_001_camera.json"}) {
    EXPECT_TRUE(std::filesystem::exists(study / name)) << name;
  }
  EXPECT_GT(std::filesystem::file_size(study / "study_001.mp4"), 2000u);
}

// The last picture stays, with a notice; a server that is started anew at its place is found, and the window ends as it
// would have.
TEST_F(WindowOnADisplay, OutlivesItsServer) {
  Program window(window_words(display_, port_, {"--renderer", "cpu"}));
  ASSERT_TRUE(server_->says("streaming to")) << server_->err();
  server_->send(SIGKILL);
  EXPECT_TRUE(window.says("the server has gone")) << window.err();
  server_->wait();
  std::vector<std::string> words = server_words();
  std::replace(words.begin(), words.end(), std::string("127.0.0.1:0"), "127.0.0.1:" + port_);
  Program again(words);
  EXPECT_TRUE(window.says("a server that was started anew")) << window.err();
  EXPECT_TRUE(again.says("streaming to")) << again.err();
  window.send(SIGINT);
  EXPECT_EQ(window.wait(), 0) << window.err();
}

TEST_F(WindowOnADisplay, PlaysARecording) {
  const std::string file = folder_ / "session.lvgrec";
  Program recording({LIVEGS_TOOL, "ctl", "--server", "127.0.0.1:" + port_, "record", "start", "--assets", file});
  ASSERT_EQ(recording.wait(), 0) << recording.err();
  Program client(client_words(port_, {"--seconds", "2", "--no-video", "--every", "0"}));
  ASSERT_EQ(client.wait(), 0) << client.err();
  server_->send(SIGTERM);
  ASSERT_EQ(server_->wait(), 0) << server_->err();
  // Ends by itself at its end, which is nearer than ten seconds.
  Program window({"/usr/bin/env", "DISPLAY=" + display_, LIVEGS_CLIENT, "--replay", file, "--from", "0.5", "--seconds",
                  "10", "--display", "window", "--size", "320x240", "--cache", folder_ / "empty", "--renderer", "cpu"});
  EXPECT_EQ(window.wait(), 0) << window.err();
  EXPECT_EQ(window.err().find("error"), std::string::npos) << window.err();
}

TEST_F(Window, WithoutADisplayItIsOneLineAndCodeOne) {
  Program window(window_words("", "1"));
  EXPECT_EQ(window.wait(), 1);
  const std::string err = window.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_NE(err.find("--display offscreen"), std::string::npos) << err;
}

TEST_F(Window, AForceThatCannotBeReadIsOneLineAndCodeTwo) {
  Program window(window_words("", "1", {"--force", "hat:1,2:3"}));
  EXPECT_EQ(window.wait(), 2);
  const std::string err = window.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_NE(err.find("OBJECT:X,Y,Z:FX,FY,FZ:SECONDS"), std::string::npos) << err;
}

}  // namespace
}  // namespace livegs
