// SPDX-License-Identifier: Apache-2.0
// Playback of a recording in the desktop window: its panel and its keys.
#include <signal.h>

#include "system/window/panel_text.h"
#include "system/window/window_hands.h"
#include "viewer/runs/replay_run.h"

namespace livegs {
namespace {

class WindowReplay : public WindowHands {
 protected:
  // Records twelve seconds with assets, in which the box is pulled and shot at. A busy machine simulates
  // less.
  void record() {
    Program server(server_words({"--record", file(), "--record-assets", "--wait-for-client"}));
    const std::string port = server.first_line();
    ASSERT_NE(port, "") << server.err();
    Program client(client_words(
        port, {"--seconds", "12", "--poke", "box", "--no-video", "--every", "0", "--renderer", "cpu"}));
    ASSERT_EQ(client.wait(), 0) << client.err();
    server.send(SIGTERM);
    ASSERT_EQ(server.wait(), 0) << server.err();
  }
  std::filesystem::path file() { return folder_ / "session.lvgrec"; }

  void run_steps() {
    ReplayOptions options;
    options.file = file();
    options.cache = folder_ / "empty";
    options.renderer = RendererChoice::Cpu;
    options.size = PictureSize{kWidth, kHeight};
    options.full_size = true;
    options.camera_file =
        folder_.write("camera.json", R"({ "position_m": [-0.05, 0.5, 2.2], "look_at_m": [-0.05, 0.25, 0],
                                                            "vertical_fov_deg": 40 })");
    std::atomic<bool> interrupted{false};
    options.on_picture = [&](const Image& shown, const ReplayOptions::Moment& moment) {
      moment_ = moment;
      see(shown, "LiveGS session.lvgrec", interrupted);
    };
    const auto done = run_replay_window(options, interrupted);
    EXPECT_TRUE(done) << done.error().message;
    expect_all_done();
  }
  // Waits until the shown time is in this range, seconds.
  void wait_until(const std::string& name, double low_s, double high_s) {
    step(name, [this, low_s, high_s](const Image&) {
      return moment_.shown_s >= low_s && moment_.shown_s <= high_s;
    });
  }
  ReplayOptions::Moment moment_;
};

// Number of pixels outside the panel that differ by more than a twentieth.
size_t changed(const Image& a, const Image& b) {
  size_t count = 0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 315; x < a.width; ++x) {
      double most = 0;
      for (int c = 0; c < 3; ++c) most = std::max<double>(most, std::abs(a.at(x, y)[c] - b.at(x, y)[c]));
      count += most > 0.05;
    }
  }
  return count;
}

TEST_F(WindowReplay, PausesStepsAndSeeks) {
  record();
  if (HasFatalFailure()) return;
  double at_s = 0;
  Image begin, now;
  const auto remember = [&] { step("a moment", [&](const Image&) { return at_s = moment_.shown_s, true; }); };
  // Playback starts automatically. While paused, time does not advance, and a step is one tick.
  step("the beginning", [&](const Image& shown) { return begin = shown, moment_.shown_s == 0; });
  wait_until("it to play", 0.3, 100);
  press_key("p");
  step("the pause", [&](const Image&) { return moment_.paused; });
  pictures(2);
  remember();
  pictures(5);
  step("no advance", [&](const Image&) { return moment_.shown_s == at_s; });
  press_key("period");
  step("the next tick",
       [&](const Image&) { return moment_.shown_s > at_s && moment_.shown_s < at_s + 1.001 / 90; });
  remember();
  press_key("period");
  step("one tick", [&](const Image&) { return std::abs(moment_.shown_s - at_s - 1.0 / 90) < 1e-6; });
  press_key("period");
  step("one more tick", [&](const Image&) { return std::abs(moment_.shown_s - at_s - 2.0 / 90) < 1e-6; });
  // Home shows the beginning with all objects.
  press_key("Home");
  step("the beginning again", [&](const Image&) { return moment_.paused && moment_.shown_s == 0; });
  pictures(2);
  step("its picture", [&](const Image& shown) { return changed(begin, shown) < 200; });
  // Five seconds forwards and backwards.
  press_key("Right");
  wait_until("five seconds on", 4.98, 5.02);
  press_key("Left");
  wait_until("the beginning once more", 0, 0.02);
  // Plays until the box has moved: it is pulled or shot.
  press_key("p");
  step("another picture", [&](const Image& shown) { return now = shown, changed(begin, shown) > 3000; });
  keep("window_recording");
  // Without and with the panel.
  press_key("h");
  step("no panel", [&](const Image& shown) { return text_pixels(shown, 10, 310, 10, 400) == 0; });
  press_key("h");
  step("the panel", [&](const Image& shown) { return text_pixels(shown, 10, 310, 10, 400) > 1000; });
  // Playback stops at the end.
  press_key("Right");
  step("its end", [&](const Image&) { return moment_.at_end; });
  remember();
  pictures(5);
  step("no advance at the end", [&](const Image&) { return moment_.shown_s == at_s; });
  keep("replay_end");
  close();
  run_steps();
  EXPECT_GT(at_s, 5.1);
  ASSERT_FALSE(now.pixels.empty());
  // There is only the playback panel, because a recording cannot be edited.
  EXPECT_GT(text_pixels(now, 10, 310, 10, 400), 800u);
  EXPECT_EQ(text_pixels(now, 881, 1270, 10, 60), 0u);
}

// The buttons do the same as the keys.
TEST_F(WindowReplay, ButtonsMatchTheKeys) {
  record();
  if (HasFatalFailure()) return;
  std::optional<int> row;
  const auto button = [&](int third) {
    return [&row, third](const Image& shown) -> std::optional<Eigen::Vector2d> {
      const auto rows = widgets(shown, 10 + 12 + 4, 56, 77, 99);
      if (!row && !rows.empty()) row = rows.front();
      return row ? std::optional(Eigen::Vector2d(10 + 12 + 276 * (2 * third + 1) / 6.0, *row)) : std::nullopt;
    };
  };
  wait_until("it to play", 0.3, 100);
  click("Pause", button(0));
  step("the pause", [&](const Image&) { return moment_.paused; });
  click("Restart", button(2));
  step("the beginning", [&](const Image&) { return moment_.paused && moment_.shown_s == 0; });
  click("Step", button(1));
  step("one tick", [&](const Image&) { return std::abs(moment_.shown_s - 1.0 / 90) < 1e-6; });
  click("Go on", button(0));
  step("playback continues", [&](const Image&) { return !moment_.paused && moment_.shown_s > 0.1; });
  close();
  run_steps();
}

}  // namespace
}  // namespace livegs
