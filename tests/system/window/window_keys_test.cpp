// SPDX-License-Identifier: Apache-2.0
// Keys and buttons that are tapped faster than pictures are drawn.
#include <thread>

#include "system/window/window_session.h"
#include "xr/window_display.h"

namespace livegs {
namespace {

constexpr int kTaps = 10;
constexpr auto kTap = std::chrono::milliseconds(12), kPicture = std::chrono::milliseconds(500);

// Taps while pictures of half a second are shown; `take` receives the input of each picture.
class WindowKeys : public WindowHands {
 protected:
  void tap_all(const std::function<void(bool down)>& press,
               const std::function<void(const WindowInput&)>& take) {
    auto display = WindowDisplay::open("taps", 200, 100);
    ASSERT_TRUE(display) << display.error().message;
    const Image dark{1, 1, {0, 0, 0, 1}};
    const auto picture = [&] {
      const auto planned = (*display)->wait_frame();
      ASSERT_TRUE(planned);
      take((*display)->input());
      ASSERT_TRUE((*display)->submit(*planned, {&dark, 1}));
    };
    WindowOverlay overlay;
    overlay.panels.shown = false;
    (*display)->set_overlay(overlay);
    picture();
    hands_ = XHands::at_window(display_, "taps");
    ASSERT_TRUE(hands_);
    hands_->move(100, 50);
    std::atomic<bool> done{false};
    std::thread tapping([&] {
      for (int i = 0; i < kTaps; ++i) {
        std::this_thread::sleep_for(5 * kTap);
        press(true);
        std::this_thread::sleep_for(kTap);
        press(false);
      }
      done = true;
    });
    while (!done) {
      std::this_thread::sleep_for(kPicture);
      picture();
    }
    for (int i = 0; i < 2 * kTaps + 1; ++i) picture();  // a button has one change per picture
    tapping.join();
  }
  void tap_all(const std::string& key, const std::function<void(const WindowInput&)>& take) {
    tap_all([&](bool down) { hands_->key(key, down); }, take);
  }
};

TEST_F(WindowKeys, ShortTapsAreCountedAtTwoPicturesASecond) {
  int shots = 0, steps = 0, pauses = 0, hides = 0, right = 0, left = 0;
  tap_all("space", [&](const WindowInput& input) { shots += input.shoot; });
  EXPECT_EQ(shots, kTaps);
  tap_all("period", [&](const WindowInput& input) { steps += input.step; });
  EXPECT_EQ(steps, kTaps);
  tap_all("Right", [&](const WindowInput& input) { right += input.jump; });
  EXPECT_EQ(right, kTaps);
  tap_all("Left", [&](const WindowInput& input) { left += input.jump; });
  EXPECT_EQ(left, -kTaps);
  tap_all("p", [&](const WindowInput& input) { pauses += input.pause; });
  EXPECT_EQ(pauses % 2, kTaps % 2);
  tap_all("h", [&](const WindowInput& input) { hides += input.hide; });
  EXPECT_EQ(hides % 2, kTaps % 2);
  bool home = false;
  tap_all("Home", [&](const WindowInput& input) { home |= input.home; });
  EXPECT_TRUE(home);
  double flown_s = 0;
  tap_all("d", [&](const WindowInput& input) { flown_s += input.flown.x() * input.passed_s; });
  // A tap flies for a refresh at 60 Hz; a picture that begins during a tap counts it as held to its end.
  EXPECT_GE(flown_s, kTaps * 0.99 / 60);
}

TEST_F(WindowKeys, ShortClicksAreCountedAtTwoPicturesASecond) {
  for (const int button : {1, 2, 3}) {
    int clicks = 0;
    bool was_down = false;
    tap_all([&](bool down) { down ? hands_->press(button) : hands_->release(button); },
            [&](const WindowInput& input) {
              const bool down = button == 1 ? input.left : button == 2 ? input.middle : input.right;
              if (button == 1) clicks += down && !was_down;
              if (button != 1) clicks += down;
              was_down = down;
            });
    // The right and middle button also count in the picture of their release.
    if (button == 1) {
      EXPECT_EQ(clicks, kTaps);
    } else {
      EXPECT_GE(clicks, kTaps);
    }
  }
}

// Each press of space within one picture of the client shoots one ball on the server; each press of full stop
// is one tick.
TEST_F(WindowClicks, EachTapWithinOnePictureActs) {
  size_t added = 0;
  double stopped_s = 0;
  const auto taps = [&](const std::string& key) {
    for (int i = 0; i < kTaps; ++i) {
      hands_->key(key, true);
      std::this_thread::sleep_for(kTap);
      hands_->key(key, false);
      std::this_thread::sleep_for(kTap);
    }
  };
  step("before the balls", [&](const Image&) { return added = watcher_.seen().added, true; });
  move(640, 300);
  act({[&] { taps("space"); }});
  step("the balls", [&](const Image&) { return watcher_.seen().added >= added + kTaps; });
  press_key("p");
  step("the pause", [&](const Image&) { return watcher_.seen().run.paused(); });
  pictures(3);
  step("the pause time", [&](const Image&) { return stopped_s = watcher_.seen().run.simulated_s(), true; });
  act({[&] { taps("period"); }});
  step("the ticks",
       [&](const Image&) { return watcher_.seen().run.simulated_s() > stopped_s + (kTaps - 0.5) / 90; });
  pictures(3);
  close();
  run_steps();
  EXPECT_EQ(watcher_.seen().added, added + kTaps);
  EXPECT_NEAR(watcher_.seen().run.simulated_s(), stopped_s + kTaps / 90.0, 1e-6);
}

}  // namespace
}  // namespace livegs
