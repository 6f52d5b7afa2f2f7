// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

// Style of the window's panels. Internal to this room; requires ImGui's context.

namespace livegs {

inline constexpr ImU32 kInk = IM_COL32(232, 234, 238, 255);
inline constexpr ImU32 kDimInk = IM_COL32(165, 172, 182, 255);
inline constexpr ImU32 kNoteInk = IM_COL32(236, 200, 120, 255);
inline constexpr ImU32 kRefusalInk = IM_COL32(255, 138, 120, 255);
inline constexpr ImU32 kForceInk = IM_COL32(255, 150, 30, 255);
inline constexpr ImU32 kPictureInk = IM_COL32(110, 170, 230, 255);
inline constexpr ImU32 kTickInk = IM_COL32(130, 205, 140, 255);
inline constexpr ImU32 kAgeInk = IM_COL32(226, 160, 110, 255);
inline constexpr ImU32 kDeviceInk = IM_COL32(190, 150, 225, 255);

inline constexpr float kFontSize_px = 14;  // at scale 1

// `scale`: of texts and widgets. Replaces style and fonts.
void set_window_style(float scale = 1);

}  // namespace livegs
