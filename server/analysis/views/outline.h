// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "splat/image.h"

namespace livegs {

// `picture` with a line of `width_px` around where `mask` (same size, first channel) is a half or more. The
// line lies outside of the mask, so that it covers nothing of what it marks; only at the picture's edge it
// has no room.
Image outlined(const Image& picture, const Image& mask, int width_px);

inline constexpr float kOutline_rgb[3] = {1.0f, 0.0f, 0.85f};  // a colour that few things have

}  // namespace livegs
