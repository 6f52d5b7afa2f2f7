// SPDX-License-Identifier: Apache-2.0
// Pictures of a window whose camera and scene are at rest.
#include <algorithm>
#include <thread>

#include "system/window/window_session.h"
#include "xr/window_display.h"

namespace livegs {
namespace {

bool rests(const RunPanel& run) {
  return std::any_of(run.lines.begin(), run.lines.end(),
                     [](const std::string& line) { return line.find("at rest") != std::string::npos; });
}

// The picture at rest is that of --full-size, after the camera has moved there and after a pause; hover and
// selection work without a new picture.
TEST_F(WindowClicks, RestsAtFullSize) {
  Image full, paused;
  const auto between_panels = [](const Image& shown) { return cropped(shown, 330, 10, 860, 790); };
  const auto at_rest = [&](const char* name, Image& kept) {
    step(name, [&](const Image& shown) {
      if (rests(run_)) kept = between_panels(shown);
      return rests(run_);
    });
  };
  move(600, 60);  // not over an object
  press_key("p");
  step("the pause", [&](const Image&) { return watcher_.seen().run.paused(); });
  pictures(3);
  at_rest("full size", full);
  close();
  run_steps();
  ASSERT_FALSE(full.pixels.empty());

  restart();
  reduced_ = true;
  move(600, 60);
  at_rest("rest", paused);
  // Forward and back again: the same camera, from other pictures.
  act({[&] { hands_->move(600, 400); }, [&] { hands_->press(3); }, [] {}, [&] { hands_->move(600, 500); },
       [] {}, [] {}});
  step("movement", [&](const Image& shown) { return psnr_db(between_panels(shown), full) < 40; });
  act({[&] { hands_->move(600, 400); }, [] {}, [&] { hands_->release(3); }, [] {}, [] {}});
  move(600, 60);
  at_rest("rest after the movement", paused);
  keep("at_rest");
  click_thing("the cushion", {0.3, 0.1, 0.1});
  step("the panel of an elastic object", [&](const Image& shown) { return fields(shown).size() >= 5; });
  step("still at rest", [&](const Image&) { return rests(run_); });
  close();
  run_steps();
  ASSERT_FALSE(paused.pixels.empty());
  EXPECT_GT(psnr_db(full, paused), 50);
}

// Another thread wakes a window that waits for events, as a message of the server does.
TEST_F(WindowHands, WaitEndsWithAMessage) {
  auto display = WindowDisplay::open("wait", 200, 100);
  ASSERT_TRUE(display) << display.error().message;
  const Image grey{1, 1, {0.5f, 0.5f, 0.5f, 1}};
  for (int i = 0; i < 10; ++i) {  // until the window is mapped and nothing changes
    const auto planned = (*display)->wait_frame();
    ASSERT_TRUE(planned);
    ASSERT_TRUE((*display)->submit(*planned, {&grey, 1}));
  }
  constexpr double kWait_s = 60;
  std::atomic<bool> ended{false};
  std::jthread message([&] {
    while (!ended) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      (*display)->wake();
    }
  });
  const int64_t begun_ns = now_ns();
  for (int i = 0; i < 5; ++i) {
    (*display)->set_wait(kWait_s);
    const auto planned = (*display)->wait_frame();
    ASSERT_TRUE(planned);
    ASSERT_TRUE((*display)->submit(*planned, {}));
  }
  EXPECT_LT(seconds_from_ns(now_ns() - begun_ns), kWait_s) << "no wait took its whole time";
  ended = true;
}

TEST_F(WindowHands, WindowWithoutANewPictureKeepsTheLast) {
  auto display = WindowDisplay::open("rest", 200, 100);
  ASSERT_TRUE(display) << display.error().message;
  const Image red{1, 1, {1, 0, 0, 1}};
  const auto picture = [&](std::span<const Image> images, Image* kept) {
    (*display)->set_wait(0.01);
    const auto planned = (*display)->wait_frame();
    ASSERT_TRUE(planned);
    WindowOverlay overlay;
    overlay.panels.shown = false;
    (*display)->set_overlay(overlay);
    if (kept) (*display)->keep_next(*kept);
    ASSERT_TRUE((*display)->submit(*planned, images));
  };
  Image first, last;
  picture({&red, 1}, &first);
  for (int i = 0; i < 5; ++i) picture({}, nullptr);
  hands_ = XHands::at_window(display_, "rest");
  ASSERT_TRUE(hands_);
  EXPECT_EQ(hands_->picture().pixels, first.pixels);
  picture({}, &last);
  EXPECT_EQ(last.pixels, first.pixels);
  EXPECT_EQ(last.at(100, 50)[0], 1.0f);
  EXPECT_EQ(last.at(100, 50)[1], 0.0f);
}

}  // namespace
}  // namespace livegs
