// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "xr/window/window_panels.h"

namespace livegs {

// Three lines over one scale from 0 to the largest value, with the last value of each beneath. In the panel
// that is being drawn, over its whole width.
void draw_frame_graph(const FrameGraph& graph);

}  // namespace livegs
