// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "splat/image.h"

namespace livegs {

// Pixels of a part of the picture that are as bright as a panel's text.
inline size_t text_pixels(const Image& image, int left, int right, int top, int bottom) {
  size_t count = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      const float* pixel = image.at(x, y);
      count += pixel[0] > 0.55f && pixel[1] > 0.55f && pixel[2] > 0.55f;
    }
  }
  return count;
}

}  // namespace livegs
