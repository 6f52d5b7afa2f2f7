// SPDX-License-Identifier: Apache-2.0
// Mouse input in the desktop window: select, edit, pause, pull and shoot.
#include <cmath>
#include <thread>

#include "material/part_places.h"
#include "system/window/window_session.h"
#include "viewer/panels/parameter_slider.h"

namespace livegs {
namespace {

size_t force_pixels(const Image& image, int left, int right) {
  size_t count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = left; x < right; ++x) count += is_colour(image.at(x, y), 255, 150, 30);
  }
  return count;
}

TEST_F(WindowClicks, SelectEditResetUndo) {
  const auto modulus_pa = [this] {
    return shown_value(SliderParameter::YoungsModulus, watcher_.object("cushion").physics).best();
  };
  const double before_pa = modulus_pa();
  ASSERT_GT(before_pa, 0);
  double changed_pa = 0;
  size_t added = 0;
  click_thing("the cushion", {0.3, 0.1, 0.1});
  step("the panel of an elastic object", [&](const Image& shown) { return fields(shown).size() >= 5; });
  keep("selected");
  // The second slider is Young's modulus.
  SliderRange range;
  step("the range of the slider", [&](const Image&) {
    range = slider_range(SliderParameter::YoungsModulus,
                         shown_value(SliderParameter::YoungsModulus, watcher_.object("cushion").physics));
    return true;
  });
  int y = 0;
  step("the slider", [&](const Image& shown) { return y = fields(shown).at(1), true; });
  const auto along = [&](double share) {
    hands_->move(kSliderLeft + share * (kSliderRight - kSliderLeft), y);
  };
  act({[&] { along(0.2); }, [] {}, [&] { hands_->press(); }, [] {}, [&] { along(0.6); }, [&] { along(0.8); },
       [] {}});
  keep("slider");
  act({[&] { hands_->release(); }});
  step("the new modulus",
       [&](const Image&) { return changed_pa = modulus_pa(), changed_pa > 3 * before_pa; });
  // A reset keeps the values set by the user.
  step("before the reset", [&](const Image&) { return added = watcher_.seen().added, true; });
  click("Reset", [&](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto row = run_row(shown);
    return row ? std::optional(Eigen::Vector2d(10 + 300 - 12 - 20, *row)) : std::nullopt;
  });
  step("the scene after the reset",
       [&](const Image&) { return watcher_.seen().run.resets() == 1 && watcher_.seen().added > added; });
  step("the modulus after the reset", [&](const Image&) { return modulus_pa() == changed_pa; });
  step("the panel after the reset", [&](const Image& shown) { return fields(shown).size() >= 5; });
  keep("reset");
  click("Undo", [&](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto rows = buttons(shown, kObjectsPanel);
    return rows.empty() ? std::nullopt : std::optional(Eigen::Vector2d(kObjectsPanel, rows.back()));
  });
  step("the previous modulus", [&](const Image&) { return modulus_pa() == before_pa; });
  keep("undone");
  close();
  run_steps();
  EXPECT_NEAR(slider_position(range, changed_pa), 0.8, 0.08);  // position of the slider at the release
}

TEST_F(WindowClicks, PauseStepShootPull) {
  double stopped_s = 0;
  size_t added = 0;
  const auto run = [&] { return watcher_.seen().run; };
  const auto run_button = [&](int third) {
    return [this, third](const Image& shown) -> std::optional<Eigen::Vector2d> {
      const auto row = run_row(shown);
      return row ? std::optional(Eigen::Vector2d(10 + 12 + 276 * (2 * third + 1) / 6.0, *row)) : std::nullopt;
    };
  };
  click("Pause", run_button(0));
  step("the pause", [&](const Image&) { return stopped_s = run().simulated_s(), run().paused(); });
  for (int i = 0; i < 5; ++i)
    step("stillness", [&](const Image&) { return run().simulated_s() == stopped_s; });
  keep("paused");
  click("Step", run_button(1));
  step("the step", [&](const Image&) { return run().simulated_s() > stopped_s; });
  step("exactly one tick",
       [&](const Image&) { return std::abs(run().simulated_s() - stopped_s - 1.0 / 90) < 1e-6; });
  click("Go on", run_button(0));
  step("simulation continues",
       [&](const Image&) { return !run().paused() && run().simulated_s() > stopped_s + 0.1; });

  // Dragging the box pulls it up and shows an arrow.
  const Eigen::Vector2d box = pixel({-0.3, 0.1, 0.1});
  act({[&, box] { hands_->move(box.x(), box.y()); }, [] {}, [] {}});
  std::vector<Image> parts;
  const auto take = [&](const char* name) {
    step(name, [&](const Image& shown) { return parts.push_back(cropped(shown, 330, 200, 730, 580)), true; });
  };
  take("before");
  act({[&] { hands_->press(); }, [] {}});
  for (int i = 1; i <= 8; ++i) act({[&, box, i] { hands_->move(box.x(), box.y() - 15 * i); }});
  step("the lifted box", [&](const Image&) { return watcher_.seen().places["box"].y() > 0.16; });
  step("an arrow", [&](const Image& shown) { return force_pixels(shown, kLeft, kRight) > 100; });
  take("pulled");
  act({[&] { hands_->release(); }});
  step("no arrow", [&](const Image& shown) { return force_pixels(shown, kLeft, kRight) == 0; });
  step("the box on the floor", [&](const Image&) { return watcher_.seen().places["box"].y() < 0.105; });
  act({[] {}, [] {}, [] {}});
  take("after");

  step("before the ball", [&](const Image&) { return added = watcher_.seen().added, true; });
  act({[&] { hands_->move(640, 300); }, [] {}, [&] { hands_->key("space", true); }, [] {},
       [&] { hands_->key("space", false); }});
  step("a ball", [&](const Image&) { return watcher_.seen().added > added; });
  act({[] {}, [] {}});
  keep("ball");
  close();
  run_steps();
  if (parts.size() == 3) {
    ASSERT_TRUE(write_png(pictures_ / "window_pull.png", side_by_side(parts)));
  }
}

// A soft body of two materials, the border at its middle.
class WindowParts : public WindowClicks {
 protected:
  std::string scene_text() const override {
    return R"({
      "environment": { "colliders": [ { "plane": {} } ] },
      "objects": [
        { "name": "cushion", "shape": { "box": { "size_m": [0.4, 0.2, 0.2] } }, "pose": { "position_m": [0, 0.1, 0] },
          "physics": { "behavior": "ELASTIC", "parts": [
            { "name": "left", "material": "polyurethane foam", "mass_share": 0.5,
              "boxes": [ { "max_m": [0, 9, 9] } ] },
            { "name": "right", "material": "natural rubber", "mass_share": 0.5 } ] } } ] })";
  }
  // Pixels between the panels with the hue of a part.
  static size_t pixels_of(const Image& image, size_t part) {
    const Eigen::Vector3f hue = part_rgb(part).normalized();
    size_t count = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = kLeft; x < kRight; ++x) {
        const Eigen::Vector3f rgb(image.at(x, y));
        count += rgb.norm() > 0.25f && rgb.normalized().dot(hue) > 0.98f;
      }
    }
    return count;
  }
};

TEST_F(WindowParts, TickShowsThePartsInColoursAndAnotherTheObjectAgain) {
  constexpr size_t kMany = 2000;  // of about 10000 pixels of a half
  const auto tick_box = [](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const std::vector<int> boxes = widgets(shown, kObjectsPanel, 46, 51, 61);
    return boxes.empty() ? std::nullopt : std::optional(Eigen::Vector2d(kObjectsPanel, boxes.front()));
  };
  click_thing("the cushion", {0, 0.1, 0.1});
  step("its own colours", [&](const Image& shown) {
    return tick_box(shown) && pixels_of(shown, 0) < kMany && pixels_of(shown, 1) < kMany;
  });
  keep("own_colours");
  click("Show parts", tick_box);
  step("colours of the parts",
       [&](const Image& shown) { return pixels_of(shown, 0) > kMany && pixels_of(shown, 1) > kMany; });
  keep("part_colours");
  act({[this] { hands_->press(); }, [] {}, [this] { hands_->release(); }});
  step("its own colours again",
       [&](const Image& shown) { return pixels_of(shown, 0) < kMany && pixels_of(shown, 1) < kMany; });
  close();
  run_steps();
}

// Without an OpenXR runtime, `--display openxr` prints the remedy and opens a window with the scene.
TEST_F(WindowClicks, OpensWithoutAHeadset) {
  Program client({"/usr/bin/env", "DISPLAY=" + display_, "XR_RUNTIME_JSON=/nowhere/at_all.json",
                  LIVEGS_CLIENT, address_, "--display", "openxr", "--cache", folder_ / "cache", "--threads",
                  "1", "--renderer", "cpu", "--camera", camera_file()});
  ASSERT_TRUE(client.says("a window is opened instead")) << client.err();
  EXPECT_NE(client.err().find("name its manifest in XR_RUNTIME_JSON"), std::string::npos) << client.err();
  const auto wait_for = [](const std::function<bool()>& happened) {
    const int64_t begun_ns = now_ns();
    while (!happened() && seconds_from_ns(now_ns() - begun_ns) < 60)
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return happened();
  };
  ASSERT_TRUE(wait_for([&] {
    return (hands_ = XHands::at_window(display_, "LiveGS " + address_)) != nullptr;
  })) << client.err();
  // Pixels of the box, by its colour.
  const auto orange = [](const Image& shown) {
    size_t count = 0;
    for (int y = 0; y < shown.height; ++y) {
      for (int x = kLeft; x < std::min(kRight, shown.width); ++x) {
        const float* pixel = shown.at(x, y);
        count += pixel[0] > 0.4f && pixel[0] > 1.7f * pixel[2];
      }
    }
    return count;
  };
  Image shown;
  EXPECT_TRUE(wait_for([&] { return orange(shown = hands_->picture()) > 2000; })) << client.err();
  EXPECT_TRUE(write_png(pictures_ / "instead_of_a_headset.png", shown));
  hands_->close();
  EXPECT_EQ(client.wait(), 0) << client.err();
}

}  // namespace
}  // namespace livegs
