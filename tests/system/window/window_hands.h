// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/clock.h"
#include "splat/image.h"
#include "system/programs/programs_fixture.h"
#include "system/window/screen.h"
#include "system/window/x_hands.h"

namespace livegs {

// Scripted input to a window of this process on a separate X display. Every click passes through X, GLFW and
// Dear ImGui. Skipped without Xvfb.
class WindowHands : public Programs {
 protected:
  static constexpr int kWidth = 1280, kHeight = 800;
  // Horizontal range between the two panels, pixels.
  static constexpr int kLeft = 315, kRight = 875;

  void SetUp() override {
    if (!Screen::there_is_one()) GTEST_SKIP() << "Xvfb: not installed; install xvfb";
    screen_ = std::make_unique<Screen>();
    display_ = screen_->display;
    ASSERT_NE(display_, "") << screen_->program->err();
    ::setenv("DISPLAY", display_.c_str(), 1);
  }

  // A step is called once per picture until it returns true.
  using Step = std::function<bool(const Image& shown)>;
  void step(std::string name, Step done) { steps_.push_back({std::move(name), std::move(done)}); }
  // Performs actions, one per picture.
  void act(std::vector<std::function<void()>> acts) {
    for (auto& one : acts) step("an action", [one = std::move(one)](const Image&) { return one(), true; });
  }
  void pictures(int count) {
    for (int i = 0; i < count; ++i) act({[] {}});
  }
  void move(double x, double y) {
    act({[this, x, y] { hands_->move(x, y); }, [] {}});
  }
  void click(const std::string& name, std::function<std::optional<Eigen::Vector2d>(const Image&)> where) {
    step("position of " + name, [this, where](const Image& shown) {
      const auto at = where(shown);
      if (at) hands_->move(at->x(), at->y());
      return at.has_value();
    });
    act({[] {}, [this] { hands_->press(); }, [] {}, [this] { hands_->release(); }, [] {}});
  }
  void press_key(const std::string& name) {
    act({[this, name] { hands_->key(name, true); }, [] {}, [this, name] { hands_->key(name, false); },
         [] {}});
  }
  // Saves the picture in the folder LIVEGS_TEST_PICTURES, if it is set.
  void keep(const std::string& name) {
    step(name, [this, name](const Image& shown) {
      return write_png(pictures_ / (name + ".png"), shown).has_value();
    });
  }
  void close() {
    act({[this] { hands_->close(); }});
  }

  // Called for each picture of the window with this title.
  void see(const Image& shown, const std::string& title, std::atomic<bool>& interrupted) {
    if (!hands_) hands_ = XHands::at_window(display_, title);
    ASSERT_TRUE(hands_);
    if (begun_ns_ == 0) begun_ns_ = now_ns();
    if (now_ < steps_.size() && steps_[now_].done(shown)) ++now_;
    if (seconds_from_ns(now_ns() - begun_ns_) < kPatience_s) return;
    (void)write_png(
        pictures_ /
            (std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()) + "_in_vain.png"),
        shown);
    interrupted = true;
  }
  // Discards the steps and the window, for another run.
  void restart() {
    steps_.clear();
    now_ = 0;
    begun_ns_ = 0;
    hands_.reset();
  }
  void expect_all_done() const {
    EXPECT_EQ(now_, steps_.size()) << "timeout while waiting for: "
                                   << (now_ < steps_.size() ? steps_[now_].name : "");
  }

  std::filesystem::path pictures_ =
      std::getenv("LIVEGS_TEST_PICTURES") ? std::getenv("LIVEGS_TEST_PICTURES") : folder_ / "";
  std::unique_ptr<Screen> screen_;
  std::string display_;
  std::unique_ptr<XHands> hands_;

 private:
  static constexpr double kPatience_s = 120;  // for all steps together
  struct NamedStep {
    std::string name;
    Step done;
  };
  std::vector<NamedStep> steps_;
  size_t now_ = 0;
  int64_t begun_ns_ = 0;
};

inline bool is_colour(const float* pixel, int r, int g, int b) {
  return std::abs(255 * pixel[0] - static_cast<float>(r)) < 2.5f &&
         std::abs(255 * pixel[1] - static_cast<float>(g)) < 2.5f &&
         std::abs(255 * pixel[2] - static_cast<float>(b)) < 2.5f;
}

inline Image cropped(const Image& from, int left, int top, int right, int bottom) {
  Image part{right - left, bottom - top, {}};
  part.pixels.resize(size_t{4} * part.width * part.height);
  for (int y = top; y < bottom; ++y)
    std::copy(from.at(left, y), from.at(left, y) + 4 * part.width, part.at(0, y - top));
  return part;
}

// Places images next to each other on white; the height is that of the highest.
inline Image side_by_side(const std::vector<Image>& parts) {
  constexpr int kGap = 8;
  Image all{-kGap, 0, {}};
  for (const Image& part : parts) {
    all.width += part.width + kGap;
    all.height = std::max(all.height, part.height);
  }
  all.pixels.assign(size_t{4} * all.width * all.height, 1.0f);
  int left = 0;
  for (const Image& part : parts) {
    for (int y = 0; y < part.height; ++y)
      std::copy(part.at(0, y), part.at(0, y) + 4 * part.width, all.at(left, y));
    left += part.width + kGap;
  }
  return all;
}

// Centres of the runs of a colour in a column that are as high as a widget.
inline std::vector<int> widgets(const Image& image, int x, int r, int g, int b) {
  std::vector<int> middles;
  int from = -1;
  for (int y = 0; y <= image.height; ++y) {
    const bool in = y < image.height && is_colour(image.at(x, y), r, g, b);
    if (in && from < 0) from = y;
    if (!in && from >= 0) {
      if (y - from >= 12 && y - from <= 30) middles.push_back((from + y) / 2);
      from = -1;
    }
  }
  return middles;
}

// Centres of the buttons in a row, from the left. Compares with the colour of Button in window_style.cpp,
// below the text.
inline std::vector<int> buttons_along(const Image& image, int y, int left, int right) {
  std::vector<int> middles;
  int from = -1;
  for (int x = left; x <= right; ++x) {
    const bool in = x < right && is_colour(image.at(x, y + 8), 56, 77, 99);
    if (in && from < 0) from = x;
    if (!in && from >= 0) {
      if (x - from >= 20) middles.push_back((from + x) / 2);
      from = -1;
    }
  }
  return middles;
}

}  // namespace livegs
