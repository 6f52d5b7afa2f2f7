// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fit/point_tracks.h"
#include "splat/image.h"

namespace livegs {

// Draws the paths of points over a picture of their first frame, darkened: measured ones white, simulated
// ones orange. At most kMaxDrawnPaths points are drawn, evenly selected.
void draw_tracks(const PointTracks& measured, const PointTracks& simulated, Image& picture);
inline constexpr size_t kMaxDrawnPaths = 60;

}  // namespace livegs
