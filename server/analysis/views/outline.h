// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "splat/image.h"

namespace livegs {

// Draws a line of `width_px` around the region of `picture` in which `mask` (same size, first channel) is at
// least 0.5. The line is outside the region and covers none of it; at the picture's edge it is cut off.
Image outlined(const Image& picture, const Image& mask, int width_px);

inline constexpr float kOutline_rgb[3] = {1.0f, 0.0f, 0.85f};  // a rare colour in scenes

}  // namespace livegs
