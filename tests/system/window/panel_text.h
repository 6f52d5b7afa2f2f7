// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>

#include "splat/image.h"

namespace livegs {

// Number of pixels as bright as panel text in a part of the picture.
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

// Number of pixels in the left panel with the colour of an error, including soft edges.
inline size_t notice_pixels(const Image& image) {
  size_t count = 0;
  for (int y = 10; y < std::min(400, image.height); ++y) {
    for (int x = 10; x < std::min(310, image.width); ++x) {
      const float* pixel = image.at(x, y);
      count += pixel[0] > 0.5f && pixel[1] < 0.63f * pixel[0] && pixel[1] > 0.4f * pixel[0] &&
               pixel[2] < 0.58f * pixel[0];
    }
  }
  return count;
}

}  // namespace livegs
