// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

namespace livegs {

// DejaVu Sans where it is installed (package fonts-dejavu-core), else ImGui's own font, larger.
// `exact`: a pixel of the atlas is one of the glyph, for who copies them; else they are finer across.
ImFont* add_window_font(ImFontAtlas& atlas, float size_px, bool exact = false);

}  // namespace livegs
