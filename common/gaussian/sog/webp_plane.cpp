// SPDX-License-Identifier: Apache-2.0
#include "gaussian/sog/webp_plane.h"

#include <webp/decode.h>

namespace livegs {
namespace {

constexpr int kLossless = 2;  // WebPBitstreamFeatures::format

}  // namespace

Result<WebpPlane> decode_webp_plane(Bytes bytes, size_t max_pixels, std::string_view name,
                                    std::string_view plane) {
  const std::string prefix = std::string(name) + ": image " + std::string(plane) + " ";
  const auto* data = reinterpret_cast<const uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK)
    return invalid_data(prefix + "is not a WebP");
  if (features.has_animation || features.format != kLossless) {
    return invalid_data(prefix + "is not a lossless WebP; export it without loss");
  }
  WebpPlane image;
  image.width = static_cast<size_t>(features.width);
  image.height = static_cast<size_t>(features.height);
  if (image.pixels() > max_pixels) {
    return invalid_data(prefix + "has " + std::to_string(image.pixels()) + " pixels, more than " +
                        std::to_string(max_pixels) + "; export it again");
  }
  image.rgba.resize(4 * image.pixels());
  if (!WebPDecodeRGBAInto(data, bytes.size(), image.rgba.data(), image.rgba.size(), 4 * features.width)) {
    return invalid_data(prefix + "is damaged or truncated");
  }
  return image;
}

}  // namespace livegs
