// SPDX-License-Identifier: Apache-2.0
// Mouse and keyboard control of the view in the desktop window.
#include <utility>

#include "system/window/panel_text.h"
#include "system/window/window_session.h"

namespace livegs {
namespace {

// Seen from +z, the orange box is 0.4 m in front of the origin and the blue cube 0.4 m behind it. The view
// orbits the origin.
class WindowCamera : public WindowClicks {
 protected:
  std::string scene_text() const override {
    return R"({
  "gravity_m_s2": [0, 0, 0],
  "objects": [
    { "name": "near", "shape": { "box": { "size_m": [0.15, 0.15, 0.15] } }, "pose": { "position_m": [0, -0.15, 0.4] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "far", "shape": { "box": { "size_m": [0.15, 0.15, 0.15] } }, "pose": { "position_m": [0, 0.15, -0.4] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } } ] })";
  }
  std::string camera_text() const override {
    return R"({ "position_m": [0, 0, 2.4], "look_at_m": [0, 0, 0], "vertical_fov_deg": 40 })";
  }
  struct Seen {
    double x = 0, y = 0;  // mean position of its pixels
    size_t pixels = 0;
  };
  // Finds a box by its hue: the first object of a scene is orange, the second blue.
  static Seen seen(const Image& shown, bool near, int left = kLeft, int right = kRight) {
    Seen all;
    for (int y = 0; y < shown.height; ++y) {
      for (int x = left; x < right; ++x) {
        const float* pixel = shown.at(x, y);
        if (!(near ? pixel[0] > 1.4f * pixel[2] && pixel[0] > 0.2f
                   : pixel[2] > 1.4f * pixel[0] && pixel[2] > 0.2f))
          continue;
        all.x += x;
        all.y += y;
        ++all.pixels;
      }
    }
    if (all.pixels > 0) {
      all.x /= static_cast<double>(all.pixels);
      all.y /= static_cast<double>(all.pixels);
    }
    return all;
  }
  // Drags with a button by (dx, dy) pixels in steps, starting at an empty place.
  void drag(int button, double dx, double dy) {
    constexpr double kX = 420, kY = 90;
    constexpr int kSteps = 4;
    move(kX, kY);
    act({[this, button] { hands_->press(button); }, [] {}});
    for (int i = 1; i <= kSteps; ++i)
      act({[=, this] { hands_->move(kX + i * dx / kSteps, kY + i * dy / kSteps); }});
    pictures(2);
    act({[this, button] { hands_->release(button); }, [] {}, [] {}});
  }
  void look(Seen& near, Seen& far) {
    step("both boxes", [&](const Image& shown) {
      near = seen(shown, true);
      far = seen(shown, false);
      return near.pixels > 500 && far.pixels > 500;
    });
  }
};

// 100 of 800 pixels turn the view by 180 / 8 = 22.5 degrees about the origin, at a distance of 2.4 m. A point
// 0.4 m in front of the origin moves by 0.4 sin / (2.4 - 0.4 cos) to the right, one behind it by 0.4 sin /
// (2.4 + 0.4 cos) to the left.
TEST_F(WindowCamera, RightDragOrbitsAndReturns) {
  Seen near[4], far[4];
  Image before, after;
  step("the scene", [](const Image& shown) { return seen(shown, true).pixels > 500; });
  move(420, 90);
  pictures(3);
  look(near[0], far[0]);
  keep("unturned");
  step("before", [&](const Image& shown) { return before = shown, true; });
  drag(3, 100, 0);
  look(near[1], far[1]);
  keep("turned");
  drag(3, -100, 0);
  look(near[2], far[2]);
  drag(3, 0, 60);
  look(near[3], far[3]);
  keep("from_above");
  close();
  run_steps();

  const double focal_px = 0.5 * kHeight / std::tan(20 * M_PI / 180), turn = 22.5 * M_PI / 180;
  EXPECT_NEAR(near[1].x - near[0].x, focal_px * 0.4 * std::sin(turn) / (2.4 - 0.4 * std::cos(turn)), 6);
  EXPECT_NEAR(far[1].x - far[0].x, -focal_px * 0.4 * std::sin(turn) / (2.4 + 0.4 * std::cos(turn)), 6);
  EXPECT_NEAR(near[2].x, near[0].x, 1);
  EXPECT_NEAR(near[2].y, near[0].y, 1);
  EXPECT_NEAR(far[2].x, far[0].x, 1);
  EXPECT_NEAR(far[2].y, far[0].y, 1);
  // From a higher position, near objects are lower in the picture and far ones higher.
  EXPECT_GT(near[3].y, near[0].y + 15);
  EXPECT_LT(far[3].y, far[0].y - 15);
}

// The middle button moves both boxes. The wheel is tested in orbit_camera_test.
TEST_F(WindowCamera, MiddleDragPans) {
  Seen near[2], far[2];
  step("the scene", [](const Image& shown) { return seen(shown, true).pixels > 500; });
  move(420, 90);
  pictures(3);
  look(near[0], far[0]);
  drag(2, 80, 40);
  look(near[1], far[1]);
  close();
  run_steps();
  // Objects at the distance of the origin follow the pointer. Nearer ones move by 2.4 / 2.0 of that, farther
  // ones by 2.4 / 2.8.
  EXPECT_NEAR(near[1].x - near[0].x, 80 * 2.4 / 2.0, 6);
  EXPECT_NEAR(near[1].y - near[0].y, 40 * 2.4 / 2.0, 6);
  EXPECT_NEAR(far[1].x - far[0].x, 80 * 2.4 / 2.8, 6);
  EXPECT_NEAR(far[1].y - far[0].y, 40 * 2.4 / 2.8, 6);
}

// A wide view of a large box. The camera moves by at most a tenth of 2.4 m per picture, 40 pixels at the box.
// So the box stays in view even if a busy machine processes the release of a key late. Panels are hidden.
class WindowFlight : public WindowCamera {
 protected:
  std::string scene_text() const override {
    return R"({
  "gravity_m_s2": [0, 0, 0],
  "objects": [
    { "name": "near", "shape": { "box": { "size_m": [0.4, 0.4, 0.4] } }, "physics": { "behavior": "RIGID", "mass_kg": 1 } } ] })";
  }
  std::string camera_text() const override {
    return R"({ "position_m": [0, 0, 2.4], "look_at_m": [0, 0, 0], "vertical_fov_deg": 90 })";
  }
  static Seen box(const Image& shown) { return seen(shown, true, 0, shown.width); }
};

// W moves forwards, S backwards, D right, E up, for as long as the key is pressed.
TEST_F(WindowFlight, KeysMoveTheCamera) {
  Seen begin, now;
  int still = 0;
  step("the scene", [](const Image& shown) { return seen(shown, true).pixels > 500; });
  move(420, 90);
  press_key("h");
  step("no panels", [](const Image& shown) { return text_pixels(shown, 10, 310, 10, 400) == 0; });
  // Ten equal pictures: the camera moves in every picture while a key is pressed.
  const auto come_to_rest = [&] {
    act({[&] { still = 0; }});
    step("no more motion", [&](const Image& shown) {
      const Seen last = std::exchange(now, box(shown));
      still = std::abs(now.x - last.x) < 0.5 && std::abs(now.y - last.y) < 0.5 && now.pixels == last.pixels
                  ? still + 1
                  : 0;
      return still == 10;
    });
  };
  const auto fly = [&](const char* key, const char* what, std::function<bool()> done) {
    come_to_rest();
    act({[&, key] { begin = now, hands_->key(key, true); }});
    step(what, [&, done](const Image& shown) { return now = box(shown), done(); });
    act({[&, key] { hands_->key(key, false); }});
  };
  fly("w", "a larger box", [&] { return now.pixels > 1.3 * static_cast<double>(begin.pixels); });
  fly("s", "a smaller box",
      [&] { return static_cast<double>(now.pixels) < 0.75 * static_cast<double>(begin.pixels); });
  fly("d", "the box farther left", [&] { return now.x < begin.x - 30; });
  fly("a", "the box farther right", [&] { return now.x > begin.x + 30; });
  fly("e", "the box lower", [&] { return now.y > begin.y + 30; });
  fly("q", "the box higher", [&] { return now.y < begin.y - 30; });
  come_to_rest();
  keep("flown");
  close();
  run_steps();
}

// Without a camera file, the first view shows all of a wide scene, with nothing under the panels.
class WindowFirstView : public WindowCamera {
 protected:
  std::string scene_text() const override {
    return R"({
  "gravity_m_s2": [0, 0, 0],
  "objects": [
    { "name": "near", "shape": { "box": { "size_m": [0.3, 0.3, 0.3] } }, "pose": { "position_m": [-0.8, 0, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } },
    { "name": "far", "shape": { "box": { "size_m": [0.3, 0.3, 0.3] } }, "pose": { "position_m": [0.8, 0, 0] },
      "physics": { "behavior": "RIGID", "mass_kg": 1 } } ] })";
  }
  std::string camera_text() const override { return ""; }
};

TEST_F(WindowFirstView, HidesNothingUnderThePanels) {
  Seen left, right;
  step("the scene",
       [](const Image& shown) { return seen(shown, true).pixels > 500 && seen(shown, false).pixels > 500; });
  move(595, 30);
  pictures(3);
  keep("first_view");
  step("the scene next to the panels", [&](const Image& shown) {
    left = seen(shown, true);
    right = seen(shown, false);
    return true;
  });
  press_key("h");
  step("no panels", [](const Image& shown) { return text_pixels(shown, 10, 310, 10, 400) == 0; });
  step("the same scene without panels", [&](const Image& shown) {
    const double near = static_cast<double>(seen(shown, true, 0, kWidth).pixels),
                 far = static_cast<double>(seen(shown, false, 0, kWidth).pixels);
    EXPECT_NEAR(static_cast<double>(left.pixels), near, 0.01 * near);
    EXPECT_NEAR(static_cast<double>(right.pixels), far, 0.01 * far);
    return true;
  });
  close();
  run_steps();
  EXPECT_NEAR(left.x + right.x, 310 + 880, 20);  // centred between the panels
}

}  // namespace
}  // namespace livegs
