// SPDX-License-Identifier: Apache-2.0
// The panels with a mouse of our own: no display is needed to know what a click does.
#include "xr/draw_panels.h"

#include <gtest/gtest.h>
#include <imgui.h>

#include <functional>

namespace livegs {
namespace {

class PanelTest : public ::testing::Test {
 protected:
  void SetUp() override {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.DisplaySize = {1280, 800};
    unsigned char* pixels = nullptr;
    int width = 0, height = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
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
    for (int i = 0; i < 3; ++i) frame();  // sizes settle
  }
  void TearDown() override { ImGui::DestroyContext(); }

  PanelActions frame() {
    ImGui::GetIO().DeltaTime = 1.0f / 60;
    ImGui::NewFrame();
    PanelActions actions = drawer_.draw(panels_, 1280, 800);
    ImGui::Render();
    return actions;
  }
  void mouse(float x, float y, bool down) {
    ImGui::GetIO().MousePos = {x, y};
    ImGui::GetIO().MouseDown[0] = down;
  }
  // Presses and lets go everywhere in the window, on a grid finer than a button, until something happens.
  std::optional<std::pair<float, float>> find(const std::function<bool(const PanelActions&)>& wanted, float left,
                                              float right) {
    for (float y = 12; y < 790; y += 9) {
      for (float x = left; x < right; x += 25) {
        for (const bool down : {false, true, false, false}) {
          mouse(x, y, down);
          if (wanted(frame())) return std::pair(x, y);
        }
      }
    }
    return std::nullopt;
  }

  WindowPanels panels_;
  PanelDrawer drawer_;
};

TEST_F(PanelTest, ButtonsSayWhatTheyAreFor) {
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.pause == true; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.step; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.reset; }, 15, 310));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.selected == 1u; }, 890, 1270));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.undo; }, 890, 1270));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.analyse; }, 890, 1270));
  EXPECT_TRUE(find([](const PanelActions& actions) { return actions.analyse_all; }, 890, 1270));
}

// However long it is dragged, a slider is one edit, when it is let go.
TEST_F(PanelTest, ASliderIsOneEditWhenItIsLetGo) {
  const auto at = find([](const PanelActions& actions) { return actions.released && actions.released->row == 1; }, 1060, 1180);
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
  EXPECT_FALSE(find([](const PanelActions& actions) { return actions.pause || actions.selected || actions.released; }, 15, 400));
}

}  // namespace
}  // namespace livegs
