// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "core/result.h"

namespace livegs {

// RGBA, row by row from the top, 0..1, in the colour space the kernels were trained in (display-encoded
// sRGB).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> pixels;  // 4 * width * height

  float* at(int x, int y) { return &pixels[4 * (static_cast<size_t>(y) * width + x)]; }
  const float* at(int x, int y) const { return &pixels[4 * (static_cast<size_t>(y) * width + x)]; }
};

// 8-bit PNG, with alpha or without. `compression` is zlib's 0..9.
Result<void> write_png(const std::filesystem::path& path, const Image& image, bool with_alpha = false,
                       int compression = 6);
Result<std::vector<std::byte>> encode_png(const Image& image, bool with_alpha = false, int compression = 6);
Result<Image> read_png(const std::filesystem::path& path);
Result<Image> decode_png(std::span<const std::byte> bytes);

// 8 bits a channel, RGB, rounded to nearest: what a PNG or a video frame holds.
std::vector<uint8_t> rgb_bytes(const Image& image);

// Peak signal-to-noise ratio over the colour channels, in dB; infinity for equal images, 0 for different
// sizes.
double psnr_db(const Image& a, const Image& b);

}  // namespace livegs
