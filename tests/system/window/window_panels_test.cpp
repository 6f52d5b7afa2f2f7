// SPDX-License-Identifier: Apache-2.0
// The panels of fragile objects and of proposals by a model, and a picture of every panel.
#include <cstdio>

#include "analysis/physics_file.h"
#include "geometry/surface/mesh_facts.h"
#include "geometry/surface/shape_mesh.h"
#include "system/window/window_session.h"

namespace livegs {
namespace {

class WindowPanelClicks : public WindowClicks {
 protected:
  std::string scene_text() const override {
    return R"({
  "environment": { "colliders": [ { "plane": {} } ] },
  "objects": [
    { "name": "cushion", "shape": { "box": { "size_m": [0.3, 0.12, 0.3] } }, "pose": { "position_m": [-0.3, 0.06, -0.1] } },
    { "name": "crate", "shape": { "box": { "size_m": [0.3, 0.3, 0.3] } }, "pose": { "position_m": [0.1, 0.15, -0.1] } },
    { "name": "parcel", "shape": { "box": { "size_m": [0.2, 0.15, 0.2] } }, "pose": { "position_m": [-0.15, 0.075, 0.3] },
      "physics": { "behavior": "RIGID" } },
    { "name": "cup", "shape": { "cylinder": { "radius_m": 0.045, "height_m": 0.1 } }, "pose": { "position_m": [0.1, 0.05, 0.3] } } ] })";
  }
  std::string camera_text() const override {
    return R"({ "position_m": [-0.08, 0.7, 1.6], "look_at_m": [-0.08, 0.12, 0], "vertical_fov_deg": 36 })";
  }
  static constexpr double kProposed_kg = 5;
  // A model's proposal from before the server start, for a crate and a parcel.
  void prepare(const std::filesystem::path& scene) override {
    for (const char* name : {"crate", "parcel"}) {
      ObjectFacts facts;
      facts.name = name;
      facts.scale_known = facts.solid = true;
      facts.mesh = mesh_facts(box_mesh({0.3, 0.3, 0.3}));
      v1::PhysicalParameters proposed = estimate_offline(facts);
      v1::EstimatedValue& mass = *proposed.mutable_mass_kg();
      mass.set_low(0.9 * kProposed_kg);
      mass.set_best(kProposed_kg);
      mass.set_high(1.1 * kProposed_kg);
      mass.set_source(v1::EstimatedValue::MODEL);
      mass.set_reason("a full one, by its label");
      v1::AnalysisRecord record;
      record.set_model("seer-1");
      record.set_review("its mass is far from what its size says");
      const auto logged =
          log_proposal(physics_file_path(scene.parent_path() / scene.stem(), name), proposed, record);
      ASSERT_TRUE(logged) << logged.error().message;
    }
  }
  // Left edges of the check boxes of a rigid object.
  static std::vector<int> tick_boxes(const Image& shown) {
    return widgets(shown, kObjectsPanel - 3, 46, 51, 61);
  }
  // Rows of buttons in the panel. Accept and Decline are in the first of two rows; Undo is in the last row.
  static size_t button_rows(const Image& shown) { return buttons(shown, kObjectsPanel).size(); }
  void click_button(const std::string& name, size_t place) {
    click(name, [place](const Image& shown) -> std::optional<Eigen::Vector2d> {
      const auto rows = buttons(shown, kObjectsPanel);
      if (rows.empty()) return std::nullopt;
      const auto all = buttons_along(shown, rows.front(), kObjectsPanel - 4, kWidth - 22);
      return all.size() > place ? std::optional(Eigen::Vector2d(all[place], rows.front())) : std::nullopt;
    });
  }
  void open(const std::string& name, const Eigen::Vector3d& point_m) {
    click_thing(name, point_m);
    step("the panel of " + name, [](const Image& shown) { return button_rows(shown) > 0; });
    move(600, 30);  // no mark on the pointer
    pictures(3);    // the panel adapts to its content within one picture
  }
  const Eigen::Vector3d cushion_{-0.3, 0.12, -0.1}, crate_{0.1, 0.15, 0.05}, parcel_{-0.15, 0.1, 0.4},
      cup_{0.1, 0.06, 0.345};
};

TEST_F(WindowPanelClicks, FragileCanBeSwitchedOffAndOn) {
  const auto fragile = [this] { return watcher_.object("cup").physics.fragile(); };
  ASSERT_TRUE(fragile());
  const auto tick_box = [&](const Image& shown) -> std::optional<Eigen::Vector2d> {
    const auto there = tick_boxes(shown);
    return there.size() == 1 ? std::optional(Eigen::Vector2d(kObjectsPanel + 4, there.front()))
                             : std::nullopt;
  };
  open("cup", cup_);
  step("one check box", [&](const Image& shown) { return tick_boxes(shown).size() == 1; });
  keep("fragile");
  click("Fragile", tick_box);
  step("the unbreakable cup", [&](const Image&) { return !fragile(); });
  move(600, 30);
  pictures(3);
  keep("not_fragile");
  click("Fragile again", tick_box);
  step("the fragile cup", [&](const Image&) { return fragile(); });
  close();
  run_steps();
}

TEST_F(WindowPanelClicks, ProposalsCanBeAcceptedAndDeclined) {
  const double parcel_kg = watcher_.object("parcel").mass_kg;
  for (const char* name : {"crate", "parcel"}) {
    ASSERT_TRUE(watcher_.object(name).proposal) << name;
    ASSERT_GT(std::abs(watcher_.object(name).mass_kg - kProposed_kg), 1) << name;
  }
  open("crate", crate_);
  step("Accept and Decline", [](const Image& shown) { return button_rows(shown) == 2; });
  keep("proposal");
  click_button("Accept", 0);
  step("the proposed mass", [&](const Image&) {
    const StreamedObject crate = watcher_.object("crate");
    return std::abs(crate.mass_kg - kProposed_kg) < 1e-6 && !crate.proposal;
  });
  move(600, 30);
  step("no Accept or Decline", [](const Image& shown) { return button_rows(shown) == 1; });
  keep("accepted");
  open("parcel", parcel_);
  step("Accept and Decline for the other object", [](const Image& shown) { return button_rows(shown) == 2; });
  click_button("Decline", 1);
  step("no pending proposal", [&](const Image&) { return !watcher_.object("parcel").proposal; });
  move(600, 30);
  step("no Accept or Decline for the other object",
       [](const Image& shown) { return button_rows(shown) == 1; });
  pictures(3);
  keep("declined");
  close();
  run_steps();
  EXPECT_EQ(watcher_.object("parcel").mass_kg, parcel_kg);
}

// Number of columns of the graph that contain a line of this hue.
template <class Hue>
int columns_of(const Image& image, int left, int right, int top, int bottom, Hue hue) {
  int count = 0;
  for (int x = left; x < right; ++x) {
    bool seen = false;
    for (int y = top; y < bottom; ++y) seen = seen || hue(image.at(x, y));
    count += seen;
  }
  return count;
}

// Times in the Run panel, as values and in the picture (draw_frame_graph.cpp).
TEST_F(WindowPanelClicks, GraphAndLatencyLineShowTheTimes) {
  constexpr int kGraphLeft = 10 + 12, kGraphRight = 10 + 300 - 12, kGraphHeight = 74;
  RunPanel run;
  Image shown;
  // A scene at rest is not drawn again, so the view turns.
  move(600, 300);
  act({[this] { hands_->press(3); }});
  auto turned = std::make_shared<int>(0);
  step("a latency", [this, turned](const Image&) {
    hands_->move(600 + ++*turned % 40, 300);
    return run_.graph.picture_ms.size() > 60 && !run_.latency.empty();
  });
  act({[this] { hands_->release(3); }});
  step("its picture", [&](const Image& now) { return shown = now, run = run_, true; });
  keep("run_panel");
  close();
  run_steps();
  ASSERT_FALSE(shown.pixels.empty());

  for (const auto* values_ms : {&run.graph.picture_ms, &run.graph.tick_ms, &run.graph.age_ms}) {
    ASSERT_GT(values_ms->size(), 60u);
    for (const float value_ms : *values_ms) EXPECT_GE(value_ms, 0);
    EXPECT_GT(*std::max_element(values_ms->begin(), values_ms->end()), 0);
  }
  double hand_ms = 0, skin_ms = -1, render_ms = 0;
  ASSERT_EQ(std::sscanf(run.latency.c_str(), "input latency %lf ms\nskin %lf ms, render %lf ms", &hand_ms,
                        &skin_ms, &render_ms),
            3)
      << run.latency;
  EXPECT_GT(hand_ms, 0);
  EXPECT_GE(skin_ms, 0);
  EXPECT_GT(render_ms, 0);

  // Rows in which the graph's background fills more than half of the width.
  int top = 0, bottom = 0;
  for (int y = 10; y < kHeight - 10; ++y) {
    int ground = 0;
    for (int x = kGraphLeft; x < kGraphRight; ++x) ground += is_colour(shown.at(x, y), 30, 34, 40);
    if (2 * ground > kGraphRight - kGraphLeft) {
      if (top == 0) top = y;
      bottom = y + 1;
    } else if (top > 0 && y > bottom + 6) {
      break;  // the floor behind a transparent panel may look the same
    }
  }
  ASSERT_GT(top, 0);
  EXPECT_NEAR(bottom - top, kGraphHeight, 6);  // rows filled by a line are not counted
  const auto blue = [](const float* pixel) { return pixel[2] > 0.5f && pixel[2] > 1.5f * pixel[0]; };
  const auto green = [](const float* pixel) {
    return pixel[1] > 0.45f && pixel[1] > 1.3f * pixel[0] && pixel[1] > 1.2f * pixel[2];
  };
  const auto orange = [](const float* pixel) { return pixel[0] > 0.5f && pixel[0] > 1.5f * pixel[2]; };
  const int half = (kGraphRight - kGraphLeft) / 2;
  EXPECT_GT(columns_of(shown, kGraphLeft, kGraphRight, top, bottom, blue), half);    // pictures
  EXPECT_GT(columns_of(shown, kGraphLeft, kGraphRight, top, bottom, green), half);   // ticks
  EXPECT_GT(columns_of(shown, kGraphLeft, kGraphRight, top, bottom, orange), half);  // ages
  // The latest value of each line below the graph, in its colour, then the latency in grey.
  for (const auto& hue : std::vector<std::function<bool(const float*)>>{blue, green, orange}) {
    EXPECT_GT(columns_of(shown, kGraphLeft, kGraphRight, bottom + 4, bottom + 24, hue), 30);
  }
  const auto dim = [](const float* pixel) {
    return pixel[0] > 0.4f && pixel[2] > 0.4f && std::abs(pixel[0] - pixel[2]) < 0.12f;
  };
  EXPECT_GT(columns_of(shown, kGraphLeft, kGraphRight, bottom + 26, bottom + 44, dim), 40);
  EXPECT_GT(columns_of(shown, kGraphLeft, kGraphRight, bottom + 44, bottom + 62, dim), 40);
}

// The last row with text in a panel from `left` to `right`.
int text_ends(const Image& image, int left, int right) {
  for (int y = image.height - 20; y > 10; --y) {
    for (int x = left + 10; x < right - 10; ++x) {
      const float* pixel = image.at(x, y);
      if (pixel[0] > 0.5f && pixel[1] > 0.5f && pixel[2] > 0.5f) return y;
    }
  }
  return 0;
}

// The first row below a panel over a light floor.
int panel_ends(const Image& image, int left) {
  int y = 20;
  while (y < image.height && image.at(left + 3, y)[0] < 0.25f) ++y;
  return y;
}

// Saves the Run panel and the Objects panel with an elastic, a fragile and a proposed object selected. Each
// panel differs and is filled with text to its end.
TEST_F(WindowPanelClicks, EveryPanelIsVisibleToItsEnd) {
  std::vector<Image> shown;
  const auto take = [&](const char* name) {
    step(name, [&](const Image& now) { return shown.push_back(now), true; });
  };
  open("cushion", cushion_);
  step("the elastic object", [](const Image& now) { return fields(now).size() == 5; });
  pictures(20);  // to fill the graph
  take("elastic");
  open("cup", cup_);
  step("the fragile object", [](const Image& now) { return tick_boxes(now).size() == 1; });
  take("fragile");
  open("crate", crate_);
  step("the proposal", [](const Image& now) { return button_rows(now) == 2; });
  take("proposal");
  close();
  run_steps();
  ASSERT_EQ(shown.size(), 3u);

  constexpr int kObjects = kWidth - 10 - 390;
  std::vector<Image> panels = {cropped(shown[0], 10, 10, 310, panel_ends(shown[0], 10) - 3)};
  for (const Image& one : shown) {
    const int end = text_ends(one, kObjects, kWidth - 10) + 20;
    EXPECT_LT(end, kHeight - 10);
    panels.push_back(cropped(one, kObjects, 10, kWidth - 10, end));
  }
  ASSERT_TRUE(write_png(pictures_ / "window_panels.png", side_by_side(panels)));
}

}  // namespace
}  // namespace livegs
