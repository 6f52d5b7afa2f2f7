// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/result.h"
#include "splat/image.h"

// Photos as files: PNG and JPEG, by content. Any thread.

namespace livegs {

// Orientation tag of EXIF, 1..8; 1: as stored. CIPA DC-008, tag 274.
struct StoredPicture {
  Image image;  // as stored, not turned
  int orientation = 1;
};
Result<StoredPicture> read_picture(const std::filesystem::path& path);
Result<StoredPicture> decode_picture(std::span<const std::byte> bytes);
Result<Image> decode_jpeg(std::span<const std::byte> bytes, int* orientation = nullptr);

// Size and orientation as stored, from the header.
struct PictureHeader {
  int width = 0, height = 0;
  int orientation = 1;
};
Result<PictureHeader> read_picture_header(const std::filesystem::path& path);

// The orientation of an EXIF block that starts with "Exif\0\0"; 1 if it is damaged or has none.
int exif_orientation(std::span<const std::byte> exif);

// The image turned upright.
Image turn_upright(const Image& image, int orientation);

}  // namespace livegs
