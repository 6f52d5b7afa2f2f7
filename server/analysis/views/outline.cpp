// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/views/outline.h"

#include <algorithm>

namespace livegs {

Image outlined(const Image& picture, const Image& mask, int width_px) {
  Image result = picture;
  const auto marked = [&](int x, int y) { return mask.at(x, y)[0] >= 0.5f; };
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (!marked(x, y)) continue;
      const bool inside = x > 0 && y > 0 && x + 1 < mask.width && y + 1 < mask.height && marked(x - 1, y) &&
                          marked(x + 1, y) && marked(x, y - 1) && marked(x, y + 1);
      if (inside) continue;
      for (int v = std::max(0, y - width_px); v <= std::min(mask.height - 1, y + width_px); ++v) {
        for (int u = std::max(0, x - width_px); u <= std::min(mask.width - 1, x + width_px); ++u) {
          if ((u - x) * (u - x) + (v - y) * (v - y) > width_px * width_px || marked(u, v)) continue;
          std::copy_n(kOutline_rgb, 3, result.at(u, v));
          result.at(u, v)[3] = 1.0f;
        }
      }
    }
  }
  return result;
}

}  // namespace livegs
