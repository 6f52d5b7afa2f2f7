// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "xr/window/window_panels.h"

namespace livegs {

// Draws three lines on one scale from 0 to the maximum, with their last values below, across the current
// panel.
void draw_frame_graph(const FrameGraph& graph);

}  // namespace livegs
