// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace livegs {

// Renders text on an opaque dark plate into an image, for the headset, which has no panels. Uses DejaVu Sans
// if it is installed (package fonts-dejavu-core), else Dear ImGui's built-in font. One thread.
class TextPlate {
 public:
  TextPlate();
  ~TextPlate();

  struct Picture {
    int width_px = 0, height_px = 0;
    std::vector<uint8_t> rgba;  // display-encoded, top row first
  };
  // Draws the text, wrapped at the plate's width; the height follows the lines and the rest is cut off.
  // `ink`: 0..255.
  Picture draw(const std::string& text, std::array<uint8_t, 3> ink) const;
  static constexpr int kWidth_px = 640, kMaxHeight_px = 256;

 private:
  struct Font;
  std::unique_ptr<Font> font_;
};

}  // namespace livegs
