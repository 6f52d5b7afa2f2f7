// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace livegs {

// Text on an opaque dark plate as a picture, for where there are no panels: in a headset. In DejaVu Sans
// where it is installed (package fonts-dejavu-core), else in Dear ImGui's own font. One thread.
class TextPlate {
 public:
  TextPlate();
  ~TextPlate();

  struct Picture {
    int width_px = 0, height_px = 0;
    std::vector<uint8_t> rgba;  // display-encoded, rows from the top
  };
  // As high as the text's lines, which are broken at the plate's width; what does not fit is left out. `ink`:
  // 0..255.
  Picture draw(const std::string& text, std::array<uint8_t, 3> ink) const;
  static constexpr int kWidth_px = 640, kMaxHeight_px = 256;

 private:
  struct Font;
  std::unique_ptr<Font> font_;
};

}  // namespace livegs
