// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "gaussian/asset/bytes.h"

namespace livegs {

// An image whose pixels are data: four bytes (r g b a) per pixel, rows from the top.
struct WebpPlane {
  size_t width = 0;
  size_t height = 0;
  std::vector<uint8_t> rgba;

  size_t pixels() const { return width * height; }
  const uint8_t* pixel(size_t i) const { return rgba.data() + 4 * i; }
};

// Decodes a lossless WebP of at most `max_pixels`. `name` is the file and `plane` the image in errors.
Result<WebpPlane> decode_webp_plane(Bytes bytes, size_t max_pixels, std::string_view name,
                                    std::string_view plane);

// The reverse, without loss and for any alpha. `name` is the format in errors.
Result<std::vector<std::byte>> encode_webp_plane(const WebpPlane& plane, std::string_view name);

}  // namespace livegs
