// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

#include <filesystem>

namespace livegs {

// DejaVu Sans in the archive to which the executable file `program` belongs, else of the system (package
// fonts-dejavu-core). Empty if there is neither.
std::filesystem::path window_font_file(const std::filesystem::path& program);

// Adds the font of the running program, else ImGui's built-in font, enlarged.
// `exact`: one atlas pixel per glyph pixel, for callers that copy glyphs; else horizontally oversampled.
ImFont* add_window_font(ImFontAtlas& atlas, float size_px, bool exact = false);

}  // namespace livegs
