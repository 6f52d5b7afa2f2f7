// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "xr/window/window_style.h"

// Widgets that several panels use. Internal to this room.

namespace livegs {

// A length of the layout, given for scale 1. Requires set_window_style().
float scaled(float px);
void coloured(ImU32 colour, const std::string& text);
bool button(const char* name, bool possible = true, float width_px = 0);
// Continues on the line of the last button if the panel is wide enough.
void same_line_if_it_fits(const char* button);
// Shown while the mouse rests on the last widget, also if it is disabled.
void tip(const std::string& text);

}  // namespace livegs
