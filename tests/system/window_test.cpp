// SPDX-License-Identifier: Apache-2.0
// The desktop window on a display that nobody looks at (Xvfb): screenshots before, during and after a pull.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "splat/image.h"
#include "system/programs_fixture.h"

namespace livegs {
namespace {

class Window : public Programs {
 protected:
  std::vector<std::string> window_words(const std::string& display, const std::string& port,
                                        std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"/usr/bin/env", "DISPLAY=" + display, LIVEGS_CLIENT, "127.0.0.1:" + port,
                                      "--display",    "window",             "--size",      "800x500",
                                      "--cache",      folder_ / "cache",    "--threads",   "2"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
};

// A server, and a display to open a window on. Skips where there is no Xvfb (deploy/packages.txt has it).
class WindowOnADisplay : public Window {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists("/usr/bin/Xvfb")) GTEST_SKIP() << "no Xvfb; install xvfb";
    screen_ = std::make_unique<Program>(std::vector<std::string>{"/usr/bin/Xvfb", "-displayfd", "1", "-screen", "0",
                                                                 "1000x700x24", "-nolisten", "tcp"});
    const std::string number = screen_->first_line();
    ASSERT_NE(number, "") << screen_->err();
    display_ = ":" + number;
    server_ = std::make_unique<Program>(server_words());
    port_ = server_->first_line();
    ASSERT_NE(port_, "") << server_->err();
  }
  std::unique_ptr<Program> screen_, server_;
  std::string display_, port_;
};

// Pixels that differ by more than a twentieth, left of the panels' lower half and all over the right.
size_t changed(const Image& a, const Image& b) {
  size_t count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      double most = 0;
      for (int c = 0; c < 3; ++c) most = std::max<double>(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      count += most > 0.05 && (y > a.height / 2 || x > a.width / 2);
    }
  }
  return count;
}

TEST_F(WindowOnADisplay, ShowsTheSceneAndAPull) {
  const std::string shots = folder_ / "shots";
  Program window(window_words(display_, port_, {"--seconds", "5", "--poke", "box", "--output", shots}));
  EXPECT_EQ(window.wait(), 0) << window.err();

  std::vector<Image> images;
  for (int i = 0; i < 20; ++i) {
    char name[32];
    std::snprintf(name, sizeof name, "window_%03d.png", i);
    const auto image = read_png(std::filesystem::path(shots) / name);
    if (!image) break;
    images.push_back(*image);
  }
  ASSERT_GE(images.size(), 4u) << window.err();
  const Image& before = images.front();
  ASSERT_EQ(before.width, 800);
  ASSERT_EQ(before.height, 500);
  float darkest = 1, brightest = 0;
  for (size_t i = 0; i < before.pixels.size(); i += 4) {
    darkest = std::min(darkest, before.pixels[i]);
    brightest = std::max(brightest, before.pixels[i]);
  }
  EXPECT_GT(brightest - darkest, 0.5f);
  // The box is drawn up and a force arrow stands at it: some hundred pixels at the least.
  size_t most = 0;
  for (const Image& image : images) most = std::max(most, changed(before, image));
  EXPECT_GT(most, 400u);

  server_->send(SIGTERM);
  EXPECT_EQ(server_->wait(), 0) << server_->err();
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

TEST_F(Window, WithoutADisplayItIsOneLineAndCodeOne) {
  Program window(window_words("", "1"));
  EXPECT_EQ(window.wait(), 1);
  const std::string err = window.err();
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  EXPECT_NE(err.find("--display offscreen"), std::string::npos) << err;
}

}  // namespace
}  // namespace livegs
