// SPDX-License-Identifier: Apache-2.0
#include "common/capture/picture/jpeg_bytes.h"

#include <cstdio>
// jpeglib.h needs the types of cstdio.
#include <jpeglib.h>

#include <cstdint>
#include <cstdlib>

namespace livegs {

std::vector<std::byte> encode_jpeg(const Image& image, int orientation) {
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  unsigned char* data = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&info, &data, &size);
  info.image_width = static_cast<JDIMENSION>(image.width);
  info.image_height = static_cast<JDIMENSION>(image.height);
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);
  jpeg_set_quality(&info, 98, TRUE);
  jpeg_start_compress(&info, TRUE);
  if (orientation != 0) {
    const unsigned char exif[] = {
        'E', 'x', 'i', 'f', 0,  0, 'M', 'M', 0, 42, 0, 0, 0,
        8,   0,   1,   1,   18, 0, 3,   0,   0, 0,  1, 0, static_cast<unsigned char>(orientation),
        0,   0,   0,   0,   0,  0};
    jpeg_write_marker(&info, JPEG_APP0 + 1, exif, sizeof exif);
  }
  std::vector<uint8_t> rgb = rgb_bytes(image);
  while (info.next_scanline < info.image_height) {
    JSAMPROW row = &rgb[size_t{3} * info.image_width * info.next_scanline];
    jpeg_write_scanlines(&info, &row, 1);
  }
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  const auto* first = reinterpret_cast<const std::byte*>(data);
  std::vector<std::byte> bytes(first, first + size);
  std::free(data);
  return bytes;
}

}  // namespace livegs
