// SPDX-License-Identifier: Apache-2.0
#include "xr/window/widgets.h"

namespace livegs {

float scaled(float px) { return px * ImGui::GetFont()->FontSize / kFontSize_px; }

void coloured(ImU32 colour, const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, colour);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

bool button(const char* name, bool possible, float width_px) {
  ImGui::BeginDisabled(!possible);
  const bool pressed = ImGui::Button(name, {width_px, 0});
  ImGui::EndDisabled();
  return pressed;
}

void same_line_if_it_fits(const char* button) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float needed = style.ItemSpacing.x + ImGui::CalcTextSize(button).x + 2 * style.FramePadding.x;
  if (ImGui::GetItemRectMax().x + needed <= ImGui::GetWindowPos().x + ImGui::GetWindowContentRegionMax().x)
    ImGui::SameLine();
}

void tip(const std::string& text) {
  if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) ImGui::SetTooltip("%s", text.c_str());
}

}  // namespace livegs
