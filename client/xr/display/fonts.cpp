// SPDX-License-Identifier: Apache-2.0
#include "xr/display/fonts.h"

namespace livegs {
namespace {

constexpr const char* kSystemFont = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
// In an archive of deploy/package, relative to the folder of the program.
constexpr const char* kArchiveFont = "../share/livegs/fonts/DejaVuSans.ttf";

}  // namespace

std::filesystem::path window_font_file(const std::filesystem::path& program) {
  std::error_code error;
  for (const std::filesystem::path& font :
       {program.parent_path() / kArchiveFont, std::filesystem::path(kSystemFont)}) {
    if (std::filesystem::exists(font, error)) return font;
  }
  return {};
}

ImFont* add_window_font(ImFontAtlas& atlas, float size_px, bool exact) {
  std::error_code error;
  ImFontConfig config;
  if (exact) {
    config.OversampleH = config.OversampleV = 1;
    config.PixelSnapH = true;
  }
  const std::filesystem::path font = window_font_file(std::filesystem::read_symlink("/proc/self/exe", error));
  if (!font.empty()) return atlas.AddFontFromFileTTF(font.c_str(), size_px, &config);
  config.SizePixels = size_px;
  return atlas.AddFontDefault(&config);
}

}  // namespace livegs
