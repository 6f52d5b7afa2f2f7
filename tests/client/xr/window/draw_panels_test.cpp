// SPDX-License-Identifier: Apache-2.0
// The panels with a simulated mouse; no display is required.
#include "xr/window/draw_panels.h"

#include <gtest/gtest.h>
#include <imgui.h>
#include <imgui_internal.h>  // for panel positions

#include <functional>

#include "xr/window/window_style.h"

namespace livegs {
namespace {

class PanelTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {width_px_, height_px_};
    set_style(1);
    panels_.objects.entries = {{"hat", "felt, elastic", "0.1 kg"}, {"cup", "stoneware, rigid", "0.27 kg"}};
    panels_.objects.selected = 0;
    panels_.objects.rows.resize(2);
    for (size_t i = 0; i < 2; ++i) {
      ValueRow& row = panels_.objects.rows[i];
      row.name = i == 0 ? "Mass" : "Friction";
      row.value = "1 kg";
      row.origin = "estimate";
      row.position = 0.5;
      row.text_at = [](double position) { return std::to_string(position); };
    }
    for (int i = 0; i < 3; ++i) frame();  // layout settles
  }
  void TearDown() override { ImGui::DestroyContext(); }
  static void set_style(float scale) {
    set_window_style(scale);
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  }

  PanelActions frame() {
    ImGui::GetIO().DeltaTime = 1.0f / 60;
    ImGui::NewFrame();
    PanelActions actions = drawer_.draw(panels_, width_px_, height_px_);
    ImGui::Render();
    return actions;
  }
  void mouse(float x, float y, bool down) {
    ImGui::GetIO().MousePos = {x, y};
    ImGui::GetIO().MouseDown[0] = down;
  }
  // Clicks everywhere in the window, on a grid finer than a button, until an action matches.
  std::optional<std::pair<float, float>> find(const std::function<bool(const PanelActions&)>& wanted,
                                              float left, float right, float top = 40) {
    for (float y = top; y < height_px_ - 10; y += 9) {
      for (float x = left; x < right; x += 25) {
        for (const bool down : {false, true, false, false}) {
          mouse(x, y, down);
          if (wanted(frame())) return std::pair(x, y);
        }
      }
    }
    return std::nullopt;
  }

  void resize(float width, float height) {
    width_px_ = width;
    height_px_ = height;
    ImGui::GetIO().DisplaySize = {width, height};
    for (int i = 0; i < 4; ++i) frame();
  }
  static ImGuiWindow* panel(const char* name) { return ImGui::FindWindowByName(name); }
  static bool is_open(const char* name) { return !panel(name)->Collapsed; }
  void show_scene() {
    ScenePanel& scene = panels_.scene;
    scene.available = true;
    scene.entries = {{"hat", "", true}, {"cup", ""}};
    scene.selected = 1;
    scene.fields = ScenePanel::Fields{};
    scene.fields->longest_side_m = 0.3;
    for (int i = 0; i < 4; ++i) frame();
  }
  // Everything of a panel is within the window or can be scrolled to, and a few lines are visible.
  void expect_usable(const char* name) const {
    const ImGuiWindow& window = *panel(name);
    EXPECT_TRUE(ImRect(0, 0, width_px_, height_px_).Contains(window.Rect()))
        << name << " ends at " << window.Rect().Max.x << " " << window.Rect().Max.y;
    EXPECT_LE(window.ContentSize.x, window.InnerRect.GetWidth()) << name << ": cut off at the right";
    const float hidden_px = window.ContentSize.y + 2 * window.WindowPadding.y - window.InnerRect.GetHeight();
    EXPECT_LE(hidden_px, window.ScrollMax.y + 1) << name << ": cannot be scrolled to its end";
    EXPECT_GE(window.InnerRect.GetHeight(), 4 * ImGui::GetTextLineHeightWithSpacing()) << name;
  }
  // Both are within the window and do not overlap.
  void expect_room_for_both() const {
    const ImRect run = panel("Run")->Rect(), objects = panel("Objects")->Rect(),
                 window(0, 0, width_px_, height_px_);
    EXPECT_TRUE(window.Contains(run)) << run.Max.x << " " << run.Max.y;
    EXPECT_TRUE(window.Contains(objects)) << objects.Min.x << " " << objects.Max.x << " " << objects.Max.y;
    EXPECT_FALSE(run.Overlaps(objects))
        << run.Max.x << " " << run.Max.y << ", " << objects.Min.x << " " << objects.Min.y;
  }
  // Clicks the arrow of the title bar.
  void click_bar(const char* name) {
    const ImRect bar = panel(name)->TitleBarRect();
    for (const bool down : {false, true, false, false}) {
      mouse(bar.Min.x + 12, bar.GetCenter().y, down);
      frame();
    }
    for (int i = 0; i < 4; ++i) frame();
  }

  float width_px_ = 1280, height_px_ = 800;
  WindowPanels panels_;
  PanelDrawer drawer_;
};

TEST_F(PanelTest, ButtonsReportTheirActions) {
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.pause == true; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.step; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.reset; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.selected == 1u; }, 890, 1270));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.undo; }, 890, 1270));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.analyse; }, 890, 1270));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.analyse_all; }, 890, 1270));
}

TEST_F(PanelTest, PartsAreATickBoxAndALegend) {
  const auto ticked = [](const PanelActions& actions) { return actions.show_parts == true; };
  EXPECT_FALSE(find(ticked, 890, 940));
  const float bare_px = panel("Objects")->ContentSize.y;
  panels_.objects.parts = {{"pot of terracotta (60 %)", {0, 0.45f, 0.7f}},
                           {"leaves of plant leaf (40 %)", {0.9f, 0.62f, 0}}};
  EXPECT_TRUE(find(ticked, 890, 940));
  for (int i = 0; i < 3; ++i) frame();
  const float box_px = panel("Objects")->ContentSize.y;
  EXPECT_GT(box_px, bare_px + 2 * ImGui::GetTextLineHeight());
  panels_.objects.parts_shown = true;
  for (int i = 0; i < 3; ++i) frame();
  EXPECT_EQ(panel("Objects")->ContentSize.y, box_px) << "nothing moves";
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.show_parts == false; }, 890, 940));
}

// Two parts, the second in two boxes.
class PartsPanelTest : public PanelTest {
 protected:
  using Kind = PartEdit::Kind;
  void SetUp() override {
    PanelTest::SetUp();
    PartsPanel division;
    division.parts.resize(2);
    division.parts[0].name = "pot";
    division.parts[1].name = "leaves";
    for (PartsPanel::Part& part : division.parts) part.share = 0.5;
    division.parts[1].boxes.resize(2);
    division.parts[1].boxes[0].min_m = {0.1, 0.2, 0.3};
    division.selected = 1;
    division.body = PartsPanel::Box{{{-1, -1, -1}}, {{1, 1, 1}}};
    panels_.objects.division = division;
    const auto header =
        find([](const PanelActions& actions) { return actions.parts_open == true; }, 1000, 1010);
    ASSERT_TRUE(header);
    below_ = header->second + ImGui::GetFrameHeight() + 4;
    for (int i = 0; i < 3; ++i) frame();
  }
  std::optional<PartEdit> found(Kind kind) {
    std::optional<PartEdit> edit;
    const auto wanted = [&](const PanelActions& actions) {
      if (actions.part_edit && actions.part_edit->kind == kind) edit = actions.part_edit;
      return edit.has_value();
    };
    (void)find(wanted, 895, 1265, below_);
    return edit;
  }
  float below_ = 0;  // the header of the section
};

TEST_F(PartsPanelTest, ButtonsAndTicksReportEdits) {
  EXPECT_FALSE(found(Kind::Estimate)) << "nothing was set by hand";
  panels_.objects.division->edited = true;
  EXPECT_TRUE(found(Kind::Estimate));
  EXPECT_TRUE(found(Kind::Add));
  ASSERT_TRUE(found(Kind::Remove));
  EXPECT_EQ(found(Kind::Remove)->part, 0u);
  EXPECT_EQ(found(Kind::AddBox)->part, 1u);
  EXPECT_EQ(found(Kind::RemoveBox)->box, 0u);
  const auto moved = found(Kind::MoveBox);  // the first tick is of the lower corner
  ASSERT_TRUE(moved);
  EXPECT_FALSE(moved->moved.min_m);
  panels_.objects.division->parts[1].boxes[0].min_m.reset();
  const auto closed = found(Kind::MoveBox);
  ASSERT_TRUE(closed && closed->moved.min_m);
  EXPECT_EQ((*closed->moved.min_m)[0], -1) << "begins at the body";
  panels_.objects.division->full = true;
  EXPECT_FALSE(found(Kind::Add));
  EXPECT_TRUE(
      find([](const PanelActions& actions) { return actions.part_selected == 0u; }, 895, 905, below_));
}

// A click into a field above ends the edit of the one below.
TEST_F(PartsPanelTest, TypedNameIsReportedOnceTheFieldIsLeft) {
  const auto field = [&](size_t part) {
    return find([&](const PanelActions& actions) { return actions.part_selected == part; }, 960, 970, below_);
  };
  const auto above = field(0);
  ASSERT_TRUE(above && field(1));
  frame();
  mouse(0, 0, false);
  for (const char letter : {'t', 'o', 'p'}) {
    ImGui::GetIO().AddInputCharacter(static_cast<unsigned>(letter));
    EXPECT_FALSE(frame().part_edit) << "not while it is typed";
  }
  std::vector<PartEdit> edits;
  for (const bool down : {false, true, false, false}) {
    mouse(above->first, above->second, down);
    if (const auto actions = frame(); actions.part_edit) edits.push_back(*actions.part_edit);
  }
  ASSERT_EQ(edits.size(), 1u);
  EXPECT_EQ(edits[0].kind, Kind::Name);
  EXPECT_EQ(edits[0].part, 1u);
  EXPECT_EQ(edits[0].text, "top");
}

TEST_F(PartsPanelTest, TakesThePlaceOfTheLegendAndFits) {
  panels_.objects.parts = {{"pot of terracotta (60 %)", {}}, {"leaves of plant leaf (40 %)", {}}};
  panels_.objects.parts_shown = true;
  EXPECT_TRUE(frame().parts_open.value());
  EXPECT_FALSE(
      find([](const PanelActions& actions) { return actions.show_parts.has_value(); }, 895, 905, below_));
  for (const float scale : {1.0f, 2.0f}) {
    set_style(scale);
    for (const auto& [width, height] : {std::pair(640, 480), std::pair(1280, 800)}) {
      resize(static_cast<float>(width), static_cast<float>(height));
      if (is_open("Objects")) expect_usable("Objects");
    }
  }
}

// A drag of any length is one edit, at the release.
TEST_F(PanelTest, SliderReleaseIsOneEdit) {
  const auto at = find(
      [](const PanelActions& actions) { return actions.released && actions.released->row == 1; }, 1060, 1180);
  ASSERT_TRUE(at);
  mouse(at->first, at->second, false);
  frame();
  int released = 0;
  double position = 0;
  const auto count = [&](const PanelActions& actions) {
    if (!actions.released) return;
    ++released;
    position = actions.released->position;
  };
  for (int i = 0; i < 10; ++i) {
    mouse(at->first + static_cast<float>(2 * i), at->second, true);
    count(frame());
  }
  EXPECT_EQ(released, 0);
  mouse(at->first + 18, at->second, false);
  for (int i = 0; i < 5; ++i) count(frame());
  EXPECT_EQ(released, 1);
  EXPECT_GT(position, 0.0);
  EXPECT_LT(position, 1.0);
}

TEST_F(PanelTest, HiddenPanelsDoNothing) {
  panels_.shown = false;
  EXPECT_FALSE(
      find([](const PanelActions& actions) { return actions.pause || actions.selected || actions.released; },
           15, 400));
}

// A recording cannot be changed: only Run is shown, without a force, with a restart button.
TEST_F(PanelTest, RecordingShowsOnlyRunPanel) {
  panels_.run.recorded = true;
  const float with_force = panel("Run")->Size.y;
  for (int i = 0; i < 4; ++i) frame();
  EXPECT_FALSE(panel("Objects")->Active);
  EXPECT_LT(panel("Run")->Size.y, with_force);
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.pause == true; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.step; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.reset; }, 15, 310));
  EXPECT_FALSE(find(
      [](const PanelActions& actions) { return actions.selected || actions.undo || actions.analyse_all; },
      890, 1270));
}

TEST_F(PanelTest, BothAreOpenInWideWindow) {
  for (const auto& [width, height] :
       {std::pair(1280, 800), std::pair(700, 500), std::pair(900, 200), std::pair(2560, 1400)}) {
    SCOPED_TRACE(width);
    resize(static_cast<float>(width), static_cast<float>(height));
    EXPECT_TRUE(is_open("Run") && is_open("Objects"));
    expect_room_for_both();
  }
}

// Columns for the scene are next to the panels; none if too little space is left.
TEST_F(PanelTest, LeavesFreeColumnsInWideWindow) {
  for (const auto& [width, height] : {std::pair(1280, 800), std::pair(2560, 1400)}) {
    SCOPED_TRACE(width);
    resize(static_cast<float>(width), static_cast<float>(height));
    const auto free = columns_beside_panels(width, false), recorded = columns_beside_panels(width, true);
    ASSERT_TRUE(free && recorded);
    EXPECT_EQ(free->first, panel("Run")->Rect().Max.x);
    EXPECT_EQ(free->second, panel("Objects")->Rect().Min.x);
    EXPECT_EQ(*recorded, std::pair(free->first, static_cast<double>(width)));
  }
  EXPECT_FALSE(columns_beside_panels(900, false));
  EXPECT_TRUE(columns_beside_panels(900, true));
  EXPECT_FALSE(columns_beside_panels(320, true));
}

TEST_F(PanelTest, OneIsOpenInNarrowWindow) {
  for (const auto& [width, height] : {std::pair(699, 500), std::pair(640, 480), std::pair(480, 300),
                                      std::pair(320, 240), std::pair(200, 150)}) {
    SCOPED_TRACE(width);
    panels_.objects.selected.reset();
    resize(1280, 800);
    resize(static_cast<float>(width), static_cast<float>(height));
    EXPECT_TRUE(is_open("Run") && !is_open("Objects"));
    expect_room_for_both();
    click_bar("Objects");
    EXPECT_TRUE(!is_open("Run") && is_open("Objects"));
    expect_room_for_both();
    click_bar("Objects");
    EXPECT_TRUE(!is_open("Run") && !is_open("Objects"));
    click_bar("Run");
    EXPECT_TRUE(is_open("Run") && !is_open("Objects"));
    // With an object selected from the start its panel is open; a notice still opens Run.
    panels_.objects.selected = 0;
    resize(1280, 800);
    resize(static_cast<float>(width), static_cast<float>(height));
    EXPECT_TRUE(!is_open("Run") && is_open("Objects"));
    expect_room_for_both();
    panels_.run.notice = "server disconnected";
    for (int i = 0; i < 4; ++i) frame();
    EXPECT_TRUE(is_open("Run") && !is_open("Objects"));
    expect_room_for_both();
    panels_.run.notice.clear();
    // The first later selection opens it too; further selections change nothing.
    panels_.objects.selected.reset();
    for (int i = 0; i < 4; ++i) frame();
    EXPECT_TRUE(is_open("Run"));
    panels_.objects.selected = 1;
    for (int i = 0; i < 4; ++i) frame();
    EXPECT_TRUE(!is_open("Run") && is_open("Objects"));
    click_bar("Run");
    panels_.objects.selected = 0;
    for (int i = 0; i < 4; ++i) frame();
    EXPECT_TRUE(is_open("Run") && !is_open("Objects"));
  }
}

// Only a value that was set by hand goes back to its estimate, and the button takes no other action.
TEST_F(PanelTest, EditedValueCanGoBackToItsEstimate) {
  const auto back = [](const PanelActions& actions) { return actions.estimated.has_value(); };
  EXPECT_FALSE(find(back, 890, 1270));
  panels_.objects.rows[1].edited = true;
  panels_.objects.rows[1].origin = "set by hand";
  const float height = panel("Objects")->ContentSize.y;
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.estimated == 1u; }, 890, 1270));
  EXPECT_FALSE(find([](const PanelActions& actions) { return actions.estimated == 0u; }, 890, 1270));
  EXPECT_EQ(panel("Objects")->ContentSize.y, height) << "nothing moves";
}

// With the Scene panel open, nothing is off the screen in small windows and at any scale.
TEST_F(PanelTest, ScenePanelFitsSmallWindows) {
  for (const float scale : {1.0f, 1.5f, 2.0f}) {
    set_style(scale);
    for (const auto& [width, height] : {std::pair(640, 480), std::pair(800, 480), std::pair(1280, 800)}) {
      SCOPED_TRACE(std::to_string(width) + " at " + std::to_string(scale));
      panels_.objects.selected = 0;
      resize(static_cast<float>(width), static_cast<float>(height));
      show_scene();
      if (!is_open("Scene")) click_bar("Scene");
      ASSERT_TRUE(is_open("Scene"));
      expect_usable("Scene");
      for (const char* name : {"Run", "Objects"}) {
        if (is_open(name)) expect_usable(name);
        EXPECT_TRUE(ImRect(0, 0, width_px_, height_px_).Contains(panel(name)->TitleBarRect())) << name;
        EXPECT_FALSE(panel(name)->Rect().Overlaps(panel("Scene")->Rect())) << name;
      }
    }
  }
}

// At a scale of two everything is twice as large.
TEST_F(PanelTest, ScaleAppliesToTextsAndPanels) {
  resize(2560, 1600);
  const float line = ImGui::GetTextLineHeight(), run = panel("Run")->Size.x;
  set_style(2);
  for (int i = 0; i < 4; ++i) frame();
  EXPECT_NEAR(ImGui::GetTextLineHeight(), 2 * line, 1e-3);
  EXPECT_EQ(panel("Run")->Size.x, 2 * run);
  EXPECT_EQ(columns_beside_panels(2560, false, 2)->second, 2560 - 2 * 400);
  expect_room_for_both();
  resize(1380, 800);  // too narrow for both at this scale
  EXPECT_TRUE(is_open("Run") != is_open("Objects"));
}

TEST_F(PanelTest, EachButtonWorksInNarrowWindow) {
  resize(330, 700);
  panels_.run.lines = {"vulkan: llvmpipe, resolution 100 %", "60 fps, 90 server ticks/s"};
  EXPECT_TRUE(is_open("Objects"));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.undo; }, 15, 320));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.redo; }, 15, 320));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.analyse; }, 15, 320));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.analyse_all; }, 15, 320));
}

}  // namespace
}  // namespace livegs
