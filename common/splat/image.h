// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/result.h"

namespace livegs {

// RGBA, rows from the top, 0..1, in the colour space used for training (display-encoded sRGB).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> pixels;  // 4 * width * height

  float* at(int x, int y) { return &pixels[4 * (static_cast<size_t>(y) * width + x)]; }
  const float* at(int x, int y) const { return &pixels[4 * (static_cast<size_t>(y) * width + x)]; }
};

// Writes an 8-bit PNG. `compression` is zlib's level, 0..9.
Result<void> write_png(const std::filesystem::path& path, const Image& image, bool with_alpha = false,
                       int compression = 6);
Result<std::vector<std::byte>> encode_png(const Image& image, bool with_alpha = false, int compression = 6);
Result<Image> read_png(const std::filesystem::path& path);
Result<Image> decode_png(std::span<const std::byte> bytes);

// 8 bits per channel, RGB, rounded to nearest, as in a PNG or a video frame.
std::vector<uint8_t> rgb_bytes(const Image& image);

// Peak signal-to-noise ratio over the colour channels, dB. Infinity for equal images, 0 for different sizes.
double psnr_db(const Image& a, const Image& b);

}  // namespace livegs
