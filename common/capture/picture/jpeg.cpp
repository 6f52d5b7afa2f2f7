// SPDX-License-Identifier: Apache-2.0
#include <csetjmp>
#include <cstdio>
// jpeglib.h needs the types of cstdio.
#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <string>

#include "capture/picture/picture_file.h"
#include "core/file.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

// Largest photo: 100 megapixels, the largest sensor of a camera; 1.6 GB as floats.
constexpr size_t kMaxPhotoPixels = 100'000'000;
// A block of 64 pixels takes at least six bits (one for each of the six blocks of a 4:2:0 unit is the limit).
constexpr size_t kMaxJpegPixelsPerByte = 512;
// Largest photo file, bytes.
constexpr uint64_t kMaxPhotoBytes = uint64_t{1} << 30;

struct JpegErrors {
  jpeg_error_mgr manager;
  jmp_buf jump;
  char message[JMSG_LENGTH_MAX];
  bool truncated;
};

void jpeg_failed(j_common_ptr info) {
  auto* errors = reinterpret_cast<JpegErrors*>(info->err);
  info->err->format_message(info, errors->message);
  longjmp(errors->jump, 1);
}

void jpeg_warned(j_common_ptr info, int level) {
  auto* errors = reinterpret_cast<JpegErrors*>(info->err);
  const int code = info->err->msg_code;
  if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER)) errors->truncated = true;
}

void start_jpeg(jpeg_decompress_struct& info, JpegErrors& errors) {
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = jpeg_failed;
  errors.manager.emit_message = jpeg_warned;
  errors.truncated = false;
  errors.message[0] = '\0';
}

struct JpegHeader {
  int width, height;
  bool four_colours;
  int orientation;
};

// Only trivially destructible locals are allowed in these two functions, because libjpeg exits by longjmp.
bool read_jpeg_header(std::span<const std::byte> bytes, JpegHeader& header, JpegErrors& errors) {
  jpeg_decompress_struct info;
  start_jpeg(info, errors);
  if (setjmp(errors.jump)) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_save_markers(&info, JPEG_APP0 + 1, 0xffff);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  header = {static_cast<int>(info.image_width), static_cast<int>(info.image_height),
            info.jpeg_color_space == JCS_CMYK || info.jpeg_color_space == JCS_YCCK, 1};
  for (const jpeg_marker_struct* marker = info.marker_list; marker; marker = marker->next) {
    const int orientation =
        exif_orientation(std::as_bytes(std::span(marker->data, static_cast<size_t>(marker->data_length))));
    if (orientation != 1) header.orientation = orientation;
  }
  jpeg_destroy_decompress(&info);
  return true;
}

// `rgb` has three bytes of each pixel.
bool read_jpeg_pixels(std::span<const std::byte> bytes, uint8_t* rgb, JpegErrors& errors) {
  jpeg_decompress_struct info;
  start_jpeg(info, errors);
  if (setjmp(errors.jump)) {
    jpeg_destroy_decompress(&info);
    return false;
  }
  jpeg_create_decompress(&info);
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&info, TRUE);
  info.out_color_space = JCS_RGB;
  info.dct_method = JDCT_ISLOW;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW row = rgb + size_t{3} * info.output_width * info.output_scanline;
    jpeg_read_scanlines(&info, &row, 1);
  }
  jpeg_finish_decompress(&info);
  jpeg_destroy_decompress(&info);
  return true;
}

bool is_jpeg(std::span<const std::byte> bytes) {
  return bytes.size() >= 3 && bytes[0] == std::byte{0xff} && bytes[1] == std::byte{0xd8} &&
         bytes[2] == std::byte{0xff};
}

bool is_png(std::span<const std::byte> bytes) {
  return bytes.size() >= 8 && bytes[0] == std::byte{0x89} && bytes[1] == std::byte{'P'};
}

Error invalid_jpeg(const JpegErrors& errors) {
  return invalid_data(std::string("JPEG: ") + errors.message + "; save or copy the photo again");
}

Result<JpegHeader> checked_header(std::span<const std::byte> bytes) {
  JpegHeader header{};
  JpegErrors errors;
  if (!read_jpeg_header(bytes, header, errors)) return invalid_jpeg(errors);
  const size_t count = static_cast<size_t>(header.width) * header.height;
  if (count == 0 || count > kMaxPhotoPixels) {
    return Error{ErrorCode::TooLarge,
                 format_text("JPEG: %d x %d pixels exceed the limit of %zu; scale the photo down",
                             header.width, header.height, kMaxPhotoPixels)};
  }
  if (count / kMaxJpegPixelsPerByte > bytes.size())
    return invalid_data(
        format_text("JPEG: %d x %d pixels do not fit in %zu bytes; copy the damaged file again", header.width,
                    header.height, bytes.size()));
  if (header.four_colours) return unsupported("JPEG: has four colours (CMYK); save it as RGB");
  return header;
}

}  // namespace

Result<Image> decode_jpeg(std::span<const std::byte> bytes, int* orientation) {
  const auto header = checked_header(bytes);
  if (!header) return header.error();
  std::vector<uint8_t> rgb(size_t{3} * header->width * header->height);
  JpegErrors errors;
  if (!read_jpeg_pixels(bytes, rgb.data(), errors)) return invalid_jpeg(errors);
  if (errors.truncated) return invalid_data("JPEG: ends early; copy the damaged file again");
  if (orientation) *orientation = header->orientation;
  Image image;
  image.width = header->width;
  image.height = header->height;
  image.pixels.resize(rgb.size() / 3 * 4);
  for (size_t i = 0; i < rgb.size() / 3; ++i) {
    for (size_t c = 0; c < 3; ++c) image.pixels[4 * i + c] = static_cast<float>(rgb[3 * i + c]) / 255.0f;
    image.pixels[4 * i + 3] = 1.0f;
  }
  return image;
}

Result<StoredPicture> decode_picture(std::span<const std::byte> bytes) {
  StoredPicture picture;
  if (is_jpeg(bytes)) {
    auto image = decode_jpeg(bytes, &picture.orientation);
    if (!image) return image.error();
    picture.image = std::move(*image);
    return picture;
  }
  if (!is_png(bytes)) return unsupported("is neither a PNG nor a JPEG; convert it");
  auto image = decode_png(bytes);
  if (!image) return image.error();
  picture.image = std::move(*image);
  return picture;
}

Result<StoredPicture> read_picture(const std::filesystem::path& path) {
  const auto bytes = read_file(path, kMaxPhotoBytes);
  if (!bytes) return bytes.error();
  auto picture = decode_picture(*bytes);
  if (!picture) return Error{picture.error().code, path.string() + ": " + picture.error().message};
  return picture;
}

Result<PictureHeader> read_picture_header(const std::filesystem::path& path) {
  const auto bytes = read_file(path, kMaxPhotoBytes);
  if (!bytes) return bytes.error();
  if (is_jpeg(*bytes)) {
    const auto header = checked_header(*bytes);
    if (!header) return Error{header.error().code, path.string() + ": " + header.error().message};
    return PictureHeader{header->width, header->height, header->orientation};
  }
  constexpr size_t kPngSizeOffset = 16;  // signature, length and name of IHDR
  if (!is_png(*bytes) || bytes->size() < kPngSizeOffset + 8)
    return unsupported(path.string() + ": is neither a PNG nor a JPEG; convert it");
  const auto big_endian = [&](size_t at) {
    uint32_t value = 0;
    for (size_t i = 0; i < 4; ++i) value = value << 8 | std::to_integer<uint32_t>((*bytes)[at + i]);
    return value;
  };
  const uint32_t width = big_endian(kPngSizeOffset), height = big_endian(kPngSizeOffset + 4);
  if (width == 0 || height == 0 || width > (1u << 24) || height > (1u << 24))
    return invalid_data(path.string() + ": PNG: has no valid size; save or copy the photo again");
  return PictureHeader{static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace livegs
