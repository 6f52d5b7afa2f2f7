// SPDX-License-Identifier: Apache-2.0
#include "xr/window/draw_arrow.h"

#include <algorithm>

#include "xr/window/window_style.h"

namespace livegs {
namespace {

constexpr ImU32 kDark = IM_COL32(20, 16, 10, 255), kLight = IM_COL32(255, 250, 240, 255);
constexpr ImU32 kPlate = IM_COL32(16, 18, 22, 215);

ImVec2 at(const Eigen::Vector2d& point) {
  return {static_cast<float>(point.x()), static_cast<float>(point.y())};
}

constexpr float kPlateWidth_px = 6, kPlateHeight_px = 3;  // around the text

// Draws text on a dark plate; `left_px` is the middle of its left edge. The plate is moved into the window.
void draw_label(ImDrawList& list, const Eigen::Vector2d& left_px, const std::string& label, ImU32 ink) {
  const ImVec2 size = ImGui::CalcTextSize(label.c_str());
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  const auto within = [](double from, float text, float plate, float whole) {
    return std::max(plate, std::min(static_cast<float>(from), whole - text - plate));
  };
  const ImVec2 from(within(left_px.x(), size.x, kPlateWidth_px, window.x),
                    within(left_px.y() - 0.5 * size.y, size.y, kPlateHeight_px, window.y));
  list.AddRectFilled({from.x - kPlateWidth_px, from.y - kPlateHeight_px},
                     {from.x + size.x + kPlateWidth_px, from.y + size.y + kPlateHeight_px}, kPlate, 4);
  list.AddText(from, ink, label.c_str());
}

}  // namespace

void draw_arrow(ImDrawList& list, const WindowArrow& arrow) {
  Eigen::Vector2d label_px = arrow.held_px + Eigen::Vector2d(16, 0);
  if (arrow.outline_px) {
    std::array<ImVec2, 7> corners;
    for (size_t i = 0; i < corners.size(); ++i) corners[i] = at((*arrow.outline_px)[i]);
    list.AddPolyline(corners.data(), 7, kLight, ImDrawFlags_Closed, 7);
    list.AddPolyline(corners.data(), 7, kDark, ImDrawFlags_Closed, 4);
    list.AddQuadFilled(corners[0], corners[1], corners[5], corners[6], kForceInk);
    list.AddTriangleFilled(corners[2], corners[3], corners[4], kForceInk);
    const Eigen::Vector2d tip = (*arrow.outline_px)[3];
    label_px = tip + Eigen::Vector2d(16, tip.y() < arrow.held_px.y() ? -10 : 10);
  }
  list.AddCircleFilled(at(arrow.held_px), 8, kLight);
  list.AddCircleFilled(at(arrow.held_px), 6.5f, kDark);
  list.AddCircleFilled(at(arrow.held_px), 4, kForceInk);
  if (!arrow.label.empty()) draw_label(list, label_px, arrow.label, IM_COL32(255, 190, 90, 255));
}

void draw_line(ImDrawList& list, const WindowLine& line) {
  if (line.points_px.size() < 2) return;
  const auto ink = [&]() -> ImU32 {
    switch (line.ink) {
      case WindowLine::Ink::X:
        return IM_COL32(230, 80, 80, 255);
      case WindowLine::Ink::Y:
        return IM_COL32(110, 200, 90, 255);
      case WindowLine::Ink::Z:
        return IM_COL32(90, 140, 240, 255);
      case WindowLine::Ink::Plane:
        return IM_COL32(240, 220, 110, 255);
      case WindowLine::Ink::Part:
        return kLight;
      case WindowLine::Ink::Grid:
        return IM_COL32(200, 200, 210, 60);
      case WindowLine::Ink::Axis:
        return IM_COL32(220, 220, 230, 130);
      default:
        return IM_COL32(255, 205, 90, 220);
    }
  }();
  std::vector<ImVec2> points;
  for (const Eigen::Vector2d& point : line.points_px) points.push_back(at(point));
  const bool faint = line.ink == WindowLine::Ink::Grid || line.ink == WindowLine::Ink::Axis;
  const int count = static_cast<int>(points.size());
  if (!faint) list.AddPolyline(points.data(), count, kDark, 0, line.width_px + 2);
  list.AddPolyline(points.data(), count, ink, 0, line.width_px);
  if (line.arrow) {
    const Eigen::Vector2d tip = line.points_px.back(),
                          along = tip - line.points_px[line.points_px.size() - 2];
    if (along.norm() > 1e-6) {
      const Eigen::Vector2d unit = along.normalized(), side(-unit.y(), unit.x());
      list.AddTriangleFilled(at(tip + 10 * unit), at(tip + 5 * side), at(tip - 5 * side), ink);
    }
  }
  if (!line.label.empty())
    draw_label(list, 0.5 * (line.points_px.front() + line.points_px.back()) + Eigen::Vector2d(8, -12),
               line.label, ink);
}

void draw_aim(ImDrawList& list, const WindowAim& aim) {
  list.AddCircle(at(aim.at_px), 9, kDark, 0, 4);
  list.AddCircle(at(aim.at_px), 9, kLight, 0, 1.5f);
  if (!aim.label.empty()) draw_label(list, aim.at_px + Eigen::Vector2d(22, 16), aim.label, kInk);
}

void draw_sentence(ImDrawList& list, const Eigen::Vector2d& size_px, const std::string& sentence) {
  const float width = ImGui::CalcTextSize(sentence.c_str()).x;
  draw_label(list, {0.5 * (size_px.x() - width), size_px.y() - 28}, sentence, kInk);
}

}  // namespace livegs
