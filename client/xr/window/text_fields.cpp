// SPDX-License-Identifier: Apache-2.0
#include "xr/window/text_fields.h"

#include <cmath>
#include <cstdio>

#include "core/text/lower_case.h"
#include "xr/window/widgets.h"

namespace livegs {
namespace {

constexpr size_t kMaxSuggestions = 12;  // before anything is typed

}  // namespace

bool contains_text(const std::string& text, const std::string& part) {
  return lower_case(text).find(lower_case(part)) != std::string::npos;
}

bool input_text(const char* id, std::string& text, int flags) {
  std::array<char, kMaxFieldText> buffer{};
  std::snprintf(buffer.data(), buffer.size(), "%s", text.c_str());
  const bool entered = ImGui::InputText(id, buffer.data(), buffer.size(), flags);
  text = buffer.data();
  return entered;
}

std::optional<std::string> TextFields::text_field(const char* id, const std::string& value) {
  const auto edited = edited_.find(id);
  std::string text = edited == edited_.end() ? value : edited->second;
  const bool entered =
      input_text(id, text, ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  if (ImGui::IsItemActive() && !entered) {
    edited_[id] = text;
    return std::nullopt;
  }
  const bool left = ImGui::IsItemDeactivated() && edited_.contains(id);
  if (left && !entered) text = edited_[id];  // the widget has already taken the value back
  edited_.erase(id);
  if (!entered && !left) return std::nullopt;
  if (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape)) || text == value) return std::nullopt;
  return text;
}

std::optional<std::array<double, 3>> TextFields::numbers(const char* id, const std::array<double, 3>& values,
                                                         const char* format) {
  std::optional<std::array<double, 3>> changed;
  const float width = (ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().ItemSpacing.x) / 3;
  for (size_t axis = 0; axis < 3; ++axis) {
    if (axis > 0) ImGui::SameLine();
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), format, std::abs(values[axis]) < 5e-5 ? 0.0 : values[axis]);
    ImGui::SetNextItemWidth(width);
    double value = 0;
    const std::string own = id + std::string(1, static_cast<char>('x' + axis));
    if (const auto typed = text_field(own.c_str(), text.data());
        typed && std::sscanf(typed->c_str(), "%lf", &value) == 1) {
      changed = values;
      (*changed)[axis] = value;
    }
  }
  return changed;
}

std::optional<std::string> TextFields::choice(const char* id, const std::string& value,
                                              const std::vector<std::string>& suggestions) {
  std::optional<std::string> chosen;
  if (!ImGui::BeginCombo(id, value.c_str())) return chosen;
  if (ImGui::IsWindowAppearing()) {
    choosing_.clear();
    ImGui::SetKeyboardFocusHere();
  }
  ImGui::SetNextItemWidth(-1);
  if (input_text("##typed", choosing_, ImGuiInputTextFlags_EnterReturnsTrue)) chosen = choosing_;
  size_t shown = 0;
  for (const std::string& suggestion : suggestions) {
    if (!choosing_.empty() && !contains_text(suggestion, choosing_)) continue;
    if (++shown > kMaxSuggestions && choosing_.empty()) break;
    if (ImGui::Selectable(suggestion.c_str())) chosen = suggestion;
  }
  if (chosen) ImGui::CloseCurrentPopup();
  ImGui::EndCombo();
  return chosen;
}

}  // namespace livegs
