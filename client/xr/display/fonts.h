// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

namespace livegs {

// Adds DejaVu Sans if it is installed (package fonts-dejavu-core), else ImGui's built-in font, enlarged.
// `exact`: one atlas pixel per glyph pixel, for callers that copy glyphs; else horizontally oversampled.
ImFont* add_window_font(ImFontAtlas& atlas, float size_px, bool exact = false);

}  // namespace livegs
