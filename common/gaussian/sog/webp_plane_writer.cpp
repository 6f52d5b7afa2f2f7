// SPDX-License-Identifier: Apache-2.0
#include <webp/encode.h>

#include "gaussian/sog/webp_plane.h"

namespace livegs {
namespace {

constexpr int kLosslessEffort = 4;  // of 0 to 9

}  // namespace

Result<std::vector<std::byte>> encode_webp_plane(const WebpPlane& plane, std::string_view name) {
  const auto fail = [&](const char* problem) {
    return invalid_argument(std::string(name) + ": " + problem + "; write .ply");
  };
  if (plane.width > WEBP_MAX_DIMENSION || plane.height > WEBP_MAX_DIMENSION)
    return fail("an image would be larger than 16383 pixels");
  WebPConfig config;
  WebPPicture picture;
  if (!WebPConfigInit(&config) || !WebPPictureInit(&picture) ||
      !WebPConfigLosslessPreset(&config, kLosslessEffort))
    return fail("the WebP library has another version");
  config.exact = 1;  // keeps the colours of pixels with alpha 0
  picture.use_argb = 1;
  picture.width = static_cast<int>(plane.width);
  picture.height = static_cast<int>(plane.height);
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  const bool good =
      WebPPictureImportRGBA(&picture, plane.rgba.data(), 4 * picture.width) && WebPEncode(&config, &picture);
  WebPPictureFree(&picture);
  std::vector<std::byte> bytes;
  if (good) {
    const auto* first = reinterpret_cast<const std::byte*>(writer.mem);
    bytes.assign(first, first + writer.size);
  }
  WebPMemoryWriterClear(&writer);
  if (!good) return fail("an image cannot be encoded");
  return bytes;
}

}  // namespace livegs
