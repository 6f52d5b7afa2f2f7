// SPDX-License-Identifier: Apache-2.0
#include "xr/display/text_layer.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <cmath>

#include "xr/display/fonts.h"

namespace livegs {
namespace {

constexpr float kLayerFontSize_px = 30, kLine_px = 38;
constexpr int kLayerMargin_px = 22;
constexpr std::array<uint8_t, 3> kLayerColour{16, 18, 22};

}  // namespace

struct TextPlate::Font {
  ImFontAtlas atlas;
  ImFont* font = nullptr;
  const uint8_t* coverage = nullptr;  // the font atlas, one byte per pixel
  int width = 0, height = 0;
};

TextPlate::TextPlate() : font_(std::make_unique<Font>()) {
  font_->font = add_window_font(font_->atlas, kLayerFontSize_px, true);
  unsigned char* coverage = nullptr;
  font_->atlas.GetTexDataAsAlpha8(&coverage, &font_->width, &font_->height);
  font_->coverage = coverage;
}

TextPlate::~TextPlate() = default;

TextPlate::Picture TextPlate::draw(const std::string& text, std::array<uint8_t, 3> ink) const {
  const ImFont& font = *font_->font;
  constexpr int kMaxLines = static_cast<int>((kMaxHeight_px - 2 * kLayerMargin_px) / kLine_px);
  std::vector<std::pair<const char*, const char*>> lines;
  const char* const end = text.data() + text.size();
  for (const char* at = text.data(); at < end && std::ssize(lines) < kMaxLines;) {
    const char* const paragraph = std::find(at, end, '\n');
    const char* next = font.CalcWordWrapPositionA(1.0f, at, paragraph, kWidth_px - 2 * kLayerMargin_px);
    if (next == at && paragraph != at) ++next;  // not even one character fits
    lines.emplace_back(at, next);
    at = next;
    while (at < paragraph && *at == ' ') ++at;
    if (at == paragraph && at < end) ++at;
  }
  Picture picture;
  picture.width_px = kWidth_px;
  picture.height_px = 2 * kLayerMargin_px +
                      static_cast<int>(kLine_px * static_cast<float>(std::max<size_t>(1, lines.size())));
  picture.rgba.resize(size_t{4} * picture.width_px * picture.height_px);
  for (size_t i = 0; i < picture.rgba.size(); i += 4) {
    std::copy(kLayerColour.begin(), kLayerColour.end(), &picture.rgba[i]);
    picture.rgba[i + 3] = 255;
  }
  const auto blend = [&](int x, int y, uint8_t coverage) {
    if (x < 0 || x >= picture.width_px || y < 0 || y >= picture.height_px) return;
    uint8_t* pixel = &picture.rgba[4 * (static_cast<size_t>(y) * picture.width_px + x)];
    for (size_t c = 0; c < 3; ++c)
      pixel[c] = static_cast<uint8_t>((pixel[c] * (255 - coverage) + ink[c] * coverage + 127) / 255);
  };
  for (size_t line = 0; line < lines.size(); ++line) {
    auto pen_x = static_cast<float>(kLayerMargin_px);
    const float top = kLayerMargin_px + kLine_px * static_cast<float>(line);
    for (const char* at = lines[line].first; at < lines[line].second;) {
      unsigned code = 0;
      at += std::max(1, ImTextCharFromUtf8(&code, at, lines[line].second));
      const ImFontGlyph* glyph = font.FindGlyph(static_cast<ImWchar>(code));
      if (!glyph) continue;
      const int left = static_cast<int>(std::lround(pen_x + glyph->X0)),
                first = static_cast<int>(std::lround(top + glyph->Y0));
      const int u = static_cast<int>(std::lround(glyph->U0 * static_cast<float>(font_->width)));
      const int v = static_cast<int>(std::lround(glyph->V0 * static_cast<float>(font_->height)));
      const int wide =
          static_cast<int>(std::lround((glyph->U1 - glyph->U0) * static_cast<float>(font_->width)));
      const int high =
          static_cast<int>(std::lround((glyph->V1 - glyph->V0) * static_cast<float>(font_->height)));
      for (int y = 0; y < high; ++y) {
        for (int x = 0; x < wide; ++x)
          blend(left + x, first + y,
                font_->coverage[static_cast<size_t>(v + y) * font_->width + static_cast<size_t>(u + x)]);
      }
      pen_x += glyph->AdvanceX;
    }
  }
  return picture;
}

}  // namespace livegs
