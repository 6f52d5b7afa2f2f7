// SPDX-License-Identifier: Apache-2.0
// CIPA DC-008 (EXIF 2.3), section 4.6: a TIFF header and a directory of 12-byte entries.
#include <string_view>

#include "capture/picture/picture_file.h"

namespace livegs {
namespace {

constexpr unsigned kOrientationTag = 274;

// Unsigned values in the byte order of the block; 0 beyond its end.
struct ExifBytes {
  std::span<const std::byte> bytes;
  bool little = true;

  unsigned value(size_t offset, size_t size) const {
    if (offset > bytes.size() || size > bytes.size() - offset) return 0;
    unsigned result = 0;
    for (size_t i = 0; i < size; ++i) {
      const size_t at = offset + (little ? size - 1 - i : i);
      result = result << 8 | std::to_integer<unsigned>(bytes[at]);
    }
    return result;
  }
};

}  // namespace

int exif_orientation(std::span<const std::byte> exif) {
  constexpr std::string_view kStart("Exif\0\0", 6);
  if (exif.size() < kStart.size() + 8 ||
      std::string_view(reinterpret_cast<const char*>(exif.data()), kStart.size()) != kStart)
    return 1;
  ExifBytes tiff{exif.subspan(kStart.size()), exif[kStart.size()] == std::byte{'I'}};
  if (tiff.value(2, 2) != 42) return 1;
  const size_t directory = tiff.value(4, 4);
  const unsigned entries = tiff.value(directory, 2);
  for (unsigned i = 0; i < entries; ++i) {
    const size_t entry = directory + 2 + size_t{12} * i;
    if (entry + 12 > tiff.bytes.size()) break;
    if (tiff.value(entry, 2) != kOrientationTag) continue;
    const unsigned orientation = tiff.value(entry + 8, 2);
    return orientation >= 1 && orientation <= 8 ? static_cast<int>(orientation) : 1;
  }
  return 1;
}

Image turn_upright(const Image& image, int orientation) {
  if (orientation <= 1 || orientation > 8) return image;
  const bool swapped = orientation >= 5;
  Image upright;
  upright.width = swapped ? image.height : image.width;
  upright.height = swapped ? image.width : image.height;
  upright.pixels.resize(image.pixels.size());
  for (int y = 0; y < upright.height; ++y) {
    for (int x = 0; x < upright.width; ++x) {
      const int mirrored_x = image.width - 1, mirrored_y = image.height - 1;
      int from_x = x, from_y = y;
      switch (orientation) {
        case 2:
          from_x = mirrored_x - x;
          break;
        case 3:
          from_x = mirrored_x - x;
          from_y = mirrored_y - y;
          break;
        case 4:
          from_y = mirrored_y - y;
          break;
        case 5:
          from_x = y;
          from_y = x;
          break;
        case 6:
          from_x = y;
          from_y = mirrored_y - x;
          break;
        case 7:
          from_x = mirrored_x - y;
          from_y = mirrored_y - x;
          break;
        default:
          from_x = mirrored_x - y;
          from_y = x;
      }
      const float* from = image.at(from_x, from_y);
      float* to = upright.at(x, y);
      for (int c = 0; c < 4; ++c) to[c] = from[c];
    }
  }
  return upright;
}

}  // namespace livegs
