// SPDX-License-Identifier: Apache-2.0
// Closing a window or interrupting a client while the scene is loading over a slow network. Uses Xvfb.
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>
#include <thread>

#include "core/clock.h"
#include "splat/image.h"
#include "system/support/fault_proxy.h"
#include "system/window/panel_text.h"
#include "system/window/window_hands.h"

namespace livegs {
namespace {

// At this rate, all assets take about 15 s.
constexpr double kSlow_mbit_s = 1, kPatience_s = 60;
constexpr int kAssets = 3;  // box, cube and floor of kBoxesScene

class WhileItLoads : public Programs {
 protected:
  void SetUp() override {
    if (!Screen::there_is_one()) GTEST_SKIP() << "Xvfb: not installed; install xvfb";
    screen_ = std::make_unique<Screen>();
    ASSERT_NE(screen_->display, "") << screen_->program->err();
    server_ = std::make_unique<Program>(server_words());
    const std::string port = server_->first_line();
    ASSERT_NE(port, "") << server_->err();
    network_ = std::make_unique<FaultProxy>(std::stoi(port));
    address_ = "127.0.0.1:" + std::to_string(network_->port());
  }
  std::unique_ptr<Program> client(const std::string& display, std::vector<std::string> more = {},
                                  const std::string& size = "480x320") {
    std::vector<std::string> words = {"/usr/bin/env",
                                      "DISPLAY=" + screen_->display,
                                      LIVEGS_CLIENT,
                                      address_,
                                      "--display",
                                      display,
                                      "--cache",
                                      folder_ / "cache",
                                      "--threads",
                                      "1",
                                      "--size",
                                      size,
                                      "--renderer",
                                      "cpu",
                                      "--connect-timeout",
                                      "600",
                                      "--output",
                                      folder_ / "view"};
    words.insert(words.end(), more.begin(), more.end());
    return std::make_unique<Program>(words);
  }
  template <class Happened>
  bool wait_for(Happened happened) {
    const int64_t begun_ns = now_ns();
    while (!happened() && seconds_from_ns(now_ns() - begun_ns) < kPatience_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return happened();
  }
  // True if an asset has arrived in part.
  bool is_fetching() {
    return wait_for([&] {
      std::error_code error;
      for (const auto& entry : std::filesystem::directory_iterator(folder_ / "cache", error)) {
        if (entry.path().extension() == ".part" && std::filesystem::file_size(entry.path(), error) > 10'000)
          return true;
      }
      return false;
    });
  }
  bool has_window() {
    return wait_for([&] {
      hands_ = XHands::at_window(screen_->display, "LiveGS " + address_);
      return hands_ != nullptr;
    });
  }
  // Number of filled columns of a progress bar in the middle of the picture.
  static int filled_columns(const Image& image) {
    int filled = 0;
    for (int x = 0; x < image.width; ++x) {
      bool blue = false;
      for (int y = image.height / 4; y < 3 * image.height / 4; ++y) {
        const float* pixel = image.at(x, y);
        blue = blue || (std::abs(255 * pixel[0] - 110) < 12 && std::abs(255 * pixel[1] - 170) < 12 &&
                        std::abs(255 * pixel[2] - 230) < 12);
      }
      filled += blue;
    }
    return filled;
  }
  // Expects the program to end before all assets have arrived. No asset may be there in part: the program can
  // end between two of them.
  void expect_end_while_fetching(Program& program, int code) {
    EXPECT_EQ(program.wait(), code) << program.err();
    int arrived = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / "cache"))
      arrived += entry.path().extension() == ".ply";
    EXPECT_LT(arrived, kAssets) << "the program waited for all assets";
  }

  std::unique_ptr<Screen> screen_;
  std::unique_ptr<Program> server_;
  std::unique_ptr<FaultProxy> network_;
  std::unique_ptr<XHands> hands_;
  std::string address_;
};

TEST_F(WhileItLoads, WindowShowsProgressAndCanBeClosed) {
  network_->set_link({.mbit_s = kSlow_mbit_s});
  const auto window = client("window");
  ASSERT_TRUE(has_window()) << window->err();
  ASSERT_TRUE(is_fetching()) << window->err();
  Image shown;
  ASSERT_TRUE(wait_for([&] { return filled_columns(shown = hands_->picture()) > 2; })) << window->err();
  EXPECT_LT(filled_columns(shown), 370);
  hands_->close();
  expect_end_while_fetching(*window, 0);
}

// Saves the window before there is a scene and after its server was killed, next to each other.
TEST_F(WhileItLoads, WindowOutlivesItsServer) {
  network_->set_link({.mbit_s = kSlow_mbit_s});
  const std::string camera =
      folder_.write("camera.json", R"({ "position_m": [-0.75, 0.5, 1.6], "look_at_m": [-0.75, 0.25, 0],
                                                              "vertical_fov_deg": 40 })");
  const auto window = client("window", {"--camera", camera}, "690x460");
  ASSERT_TRUE(has_window()) << window->err();
  Image loading, gone;
  const auto orange = [](const Image& image) {
    size_t count = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 315; x < image.width; ++x)
        count += image.at(x, y)[0] > 0.4f && image.at(x, y)[0] > 1.7f * image.at(x, y)[2];
    }
    return count;
  };
  ASSERT_TRUE(wait_for([&] { return filled_columns(loading = hands_->picture()) > 40; })) << window->err();
  network_->set_link({});
  ASSERT_TRUE(wait_for([&] { return orange(gone = hands_->picture()) > 2000; })) << window->err();
  EXPECT_EQ(notice_pixels(gone), 0u);
  server_->send(SIGKILL);
  ASSERT_TRUE(wait_for([&] { return notice_pixels(gone = hands_->picture()) > 100; })) << window->err();
  EXPECT_GT(orange(gone), 2000u);
  const char* folder = std::getenv("LIVEGS_TEST_PICTURES");
  ASSERT_TRUE(write_png(std::filesystem::path(folder ? folder : folder_ / "") / "window_notices.png",
                        side_by_side({loading, gone})));
  hands_->close();
  EXPECT_EQ(window->wait(), 0) << window->err();
}

TEST_F(WhileItLoads, WindowCanBeClosedBeforeTheJoin) {
  network_->cut();
  const auto window = client("window");
  ASSERT_TRUE(has_window()) << window->err();
  ASSERT_TRUE(wait_for([&] { return network_->connections() > 0; })) << window->err();
  hands_->close();
  EXPECT_EQ(window->wait(), 0) << window->err();
}

TEST_F(WhileItLoads, WindowCanBeInterrupted) {
  network_->set_link({.mbit_s = kSlow_mbit_s});
  const auto window = client("window");
  ASSERT_TRUE(is_fetching()) << window->err();
  window->send(SIGINT);
  expect_end_while_fetching(*window, 0);
}

// An offscreen client has no picture yet when it is interrupted.
TEST_F(WhileItLoads, OffscreenClientCanBeInterrupted) {
  network_->set_link({.mbit_s = kSlow_mbit_s});
  const auto run = client("offscreen", {"--no-video"});
  ASSERT_TRUE(is_fetching()) << run->err();
  run->send(SIGINT);
  expect_end_while_fetching(*run, 1);
  EXPECT_NE(run->err().find("scene: loading was interrupted"), std::string::npos) << run->err();
}

}  // namespace
}  // namespace livegs
