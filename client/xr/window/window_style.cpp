// SPDX-License-Identifier: Apache-2.0
#include "xr/window/window_style.h"

#include "xr/display/fonts.h"

namespace livegs {
namespace {

ImVec4 colour(float r, float g, float b, float a = 1.0f) { return {r, g, b, a}; }

}  // namespace

void set_window_style(float scale) {
  ImGui::GetIO().Fonts->Clear();
  add_window_font(*ImGui::GetIO().Fonts, kFontSize_px * scale);
  ImGui::GetStyle() = ImGuiStyle();
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowRounding = 6;
  style.FrameRounding = style.GrabRounding = 4;
  style.WindowBorderSize = 0;
  style.WindowPadding = {12, 10};
  style.FramePadding = {7, 4};
  style.ItemSpacing = {8, 6};
  style.CellPadding = {4, 3};
  style.ScrollbarSize = 10;
  style.GrabMinSize = 12;
  style.ScaleAllSizes(scale);
  ImVec4* colours = style.Colors;
  colours[ImGuiCol_Text] = ImGui::ColorConvertU32ToFloat4(kInk);
  colours[ImGuiCol_WindowBg] = colour(0.09f, 0.10f, 0.12f, 0.90f);
  colours[ImGuiCol_TitleBg] = colour(0.12f, 0.14f, 0.17f);
  colours[ImGuiCol_TitleBgActive] = colour(0.15f, 0.19f, 0.24f);
  colours[ImGuiCol_TitleBgCollapsed] = colour(0.12f, 0.14f, 0.17f, 0.85f);
  colours[ImGuiCol_FrameBg] = colour(0.18f, 0.20f, 0.24f);
  colours[ImGuiCol_FrameBgHovered] = colour(0.23f, 0.26f, 0.31f);
  colours[ImGuiCol_FrameBgActive] = colour(0.25f, 0.30f, 0.37f);
  colours[ImGuiCol_Button] = colour(0.22f, 0.30f, 0.39f);
  colours[ImGuiCol_ButtonHovered] = colour(0.28f, 0.39f, 0.50f);
  colours[ImGuiCol_ButtonActive] = colour(0.34f, 0.48f, 0.62f);
  colours[ImGuiCol_SliderGrab] = colour(0.50f, 0.66f, 0.82f);
  colours[ImGuiCol_SliderGrabActive] = colour(0.62f, 0.78f, 0.94f);
  colours[ImGuiCol_CheckMark] = colour(0.62f, 0.78f, 0.94f);
  colours[ImGuiCol_Header] = colour(0.24f, 0.36f, 0.48f);
  colours[ImGuiCol_HeaderHovered] = colour(0.22f, 0.30f, 0.39f);
  colours[ImGuiCol_HeaderActive] = colour(0.28f, 0.42f, 0.56f);
  colours[ImGuiCol_Separator] = colour(0.28f, 0.31f, 0.36f);
}

}  // namespace livegs
