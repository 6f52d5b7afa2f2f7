// SPDX-License-Identifier: Apache-2.0
#include "xr/window/draw_frame_graph.h"

#include <algorithm>
#include <cstdio>

#include "xr/window/widgets.h"
#include "xr/window/window_style.h"

namespace livegs {
namespace {

constexpr float kHeight_px = 74;

// Rounds up to 1, 2, 5, 10, 20, …
float round_up(float value) {
  float step = 1;
  for (int i = 0; step < value; ++i) step *= i % 3 == 1 ? 2.5f : 2.0f;
  return step;
}

}  // namespace

void draw_frame_graph(const FrameGraph& graph) {
  struct Line {
    const char* name;
    const std::vector<float>& values_ms;
    ImU32 colour;
  };
  const Line lines[] = {{"picture", graph.picture_ms, kPictureInk},
                        {"tick", graph.tick_ms, kTickInk},
                        {"age", graph.age_ms, kAgeInk},
                        {"device", graph.device_ms, kDeviceInk}};
  float most = 10;
  for (const Line& line : lines) {
    for (float value : line.values_ms) most = std::max(most, value);
  }
  most = round_up(most);
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const ImVec2 from = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const ImVec2 to(from.x + width, from.y + scaled(kHeight_px));
  list.AddRectFilled(from, to, IM_COL32(30, 34, 40, 255), 4);
  for (int quarter = 1; quarter < 4; ++quarter) {
    const float y = from.y + scaled(kHeight_px) * 0.25f * static_cast<float>(quarter);
    list.AddLine({from.x, y}, {to.x, y}, IM_COL32(52, 58, 66, 255));
  }
  list.PushClipRect(from, to, true);
  for (const Line& line : lines) {
    const size_t count = line.values_ms.size();
    std::vector<ImVec2> points(count);
    for (size_t i = 0; i < count; ++i) {
      const float along = count > 1 ? static_cast<float>(i) / static_cast<float>(count - 1) : 0.0f;
      points[i] = {from.x + along * width,
                   to.y - 2 - (scaled(kHeight_px) - 4) * std::min(1.0f, line.values_ms[i] / most)};
    }
    list.AddPolyline(points.data(), static_cast<int>(count), line.colour, 0, 1.5f);
  }
  list.PopClipRect();
  char scale[32];
  std::snprintf(scale, sizeof scale, "%.0f ms", most);
  list.AddText({from.x + 5, from.y + 2}, kDimInk, scale);
  ImGui::Dummy({width, scaled(kHeight_px)});
  for (const Line& line : lines) {
    if (&line == &lines[3] && line.values_ms.empty()) continue;
    char text[48];
    const float newest_ms = line.values_ms.empty() ? 0.0f : line.values_ms.back();
    std::snprintf(text, sizeof text, newest_ms < 100 ? "%s %.1f ms" : "%s %.0f ms", line.name, newest_ms);
    if (&line != lines && &line != &lines[3]) ImGui::SameLine(0, 14);
    ImGui::PushStyleColor(ImGuiCol_Text, line.colour);
    ImGui::TextUnformatted(text);
    ImGui::PopStyleColor();
  }
}

}  // namespace livegs
