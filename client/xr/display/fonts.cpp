// SPDX-License-Identifier: Apache-2.0
#include "xr/display/fonts.h"

#include <filesystem>

namespace livegs {
namespace {

constexpr const char* kFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

}  // namespace

ImFont* add_window_font(ImFontAtlas& atlas, float size_px, bool exact) {
  std::error_code error;
  ImFontConfig config;
  if (exact) {
    config.OversampleH = config.OversampleV = 1;
    config.PixelSnapH = true;
  }
  if (std::filesystem::exists(kFont, error)) return atlas.AddFontFromFileTTF(kFont, size_px, &config);
  config.SizePixels = size_px;
  return atlas.AddFontDefault(&config);
}

}  // namespace livegs
