// SPDX-License-Identifier: Apache-2.0
#include "splat/image.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {

std::vector<uint8_t> rgb_bytes(const Image& image) {
  const size_t count = static_cast<size_t>(image.width) * image.height;
  std::vector<uint8_t> bytes(3 * count);
  for (size_t i = 0; i < count; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      // This argument order maps NaN to 0.
      const float value = std::min(1.0f, std::max(0.0f, image.pixels[4 * i + c]));
      bytes[3 * i + c] = static_cast<uint8_t>(value * 255.0f + 0.5f);
    }
  }
  return bytes;
}

double psnr_db(const Image& a, const Image& b) {
  if (a.width != b.width || a.height != b.height) return 0.0;
  const size_t count = static_cast<size_t>(a.width) * a.height;
  double sum = 0.0;
  for (size_t i = 0; i < count; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      const double difference = static_cast<double>(a.pixels[4 * i + c]) - b.pixels[4 * i + c];
      sum += difference * difference;
    }
  }
  if (sum == 0.0) return std::numeric_limits<double>::infinity();
  return 10.0 * std::log10(3.0 * static_cast<double>(count) / sum);
}

}  // namespace livegs
