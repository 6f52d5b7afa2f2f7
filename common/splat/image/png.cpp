// SPDX-License-Identifier: Apache-2.0
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <new>
#include <string>

#include "core/file.h"
#include "splat/image.h"

namespace livegs {
namespace {

// 8192 x 4096: twice the widest eye buffer in either direction, 512 MiB once decoded to floats.
constexpr size_t kMaxPngPixels = size_t{1} << 25;

// Deflate cannot expand a byte to more than 1032 (RFC 1951: 258 bytes a match of two bits), and a byte holds
// at most 8 pixels, so a file can be asked for no more pixels than this a byte.
constexpr size_t kMaxPixelsPerByte = 1032 * 8;

void append_bytes(png_structp png, png_bytep data, size_t size) {
  auto& bytes = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(png));
  bool fits = true;
  try {
    const auto* begin = reinterpret_cast<const std::byte*>(data);
    bytes.insert(bytes.end(), begin, begin + size);
  } catch (const std::bad_alloc&) {
    fits = false;
  }
  if (!fits) png_error(png, "out of memory");
}

void flush_nothing(png_structp) {}

void keep_error(png_structp png, png_const_charp message) {
  auto* text = static_cast<char*>(png_get_error_ptr(png));
  std::strncpy(text, message, 127);
  longjmp(png_jmpbuf(png), 1);
}

void ignore_warning(png_structp, png_const_charp) {}

// Only plain variables live here, because libpng leaves by longjmp.
bool encode(const uint8_t* rows, int width, int height, int channels, int compression,
            std::vector<std::byte>* bytes, char* message) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, keep_error, ignore_warning);
  if (!png) return false;
  png_infop info = png_create_info_struct(png);
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_set_write_fn(png, bytes, append_bytes, flush_nothing);
  png_set_IHDR(png, info, width, height, 8, channels == 4 ? PNG_COLOR_TYPE_RGBA : PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_set_compression_level(png, compression);
  // Choosing among all five filters costs more than level 1 of deflate itself.
  if (compression < 6)
    png_set_filter(png, PNG_FILTER_TYPE_BASE, compression == 0 ? PNG_FILTER_NONE : PNG_FILTER_SUB);
  png_write_info(png, info);
  for (int y = 0; y < height; ++y) png_write_row(png, rows + static_cast<size_t>(y) * width * channels);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

std::vector<uint8_t> rgba_bytes(const Image& image) {
  const std::vector<uint8_t> rgb = rgb_bytes(image);
  std::vector<uint8_t> bytes(rgb.size() / 3 * 4);
  for (size_t i = 0; i < rgb.size() / 3; ++i) {
    std::memcpy(&bytes[4 * i], &rgb[3 * i], 3);
    const float alpha = std::min(1.0f, std::max(0.0f, image.pixels[4 * i + 3]));
    bytes[4 * i + 3] = static_cast<uint8_t>(alpha * 255.0f + 0.5f);
  }
  return bytes;
}

}  // namespace

Result<std::vector<std::byte>> encode_png(const Image& image, bool with_alpha, int compression) {
  if (compression < 0 || compression > 9) {
    return invalid_argument("PNG compression " + std::to_string(compression) + " is not in 0..9");
  }
  if (image.width <= 0 || image.height <= 0 ||
      image.pixels.size() != 4 * static_cast<size_t>(image.width) * image.height) {
    return invalid_argument("an image of " + std::to_string(image.width) + " x " +
                            std::to_string(image.height) + " pixels with " +
                            std::to_string(image.pixels.size()) + " values is not written as PNG");
  }
  const std::vector<uint8_t> rows = with_alpha ? rgba_bytes(image) : rgb_bytes(image);
  std::vector<std::byte> bytes;
  char message[128] = {};
  if (!encode(rows.data(), image.width, image.height, with_alpha ? 4 : 3, compression, &bytes, message)) {
    return Error{ErrorCode::Internal, std::string("PNG encoder: ") + message};
  }
  return bytes;
}

Result<void> write_png(const std::filesystem::path& path, const Image& image, bool with_alpha,
                       int compression) {
  const auto bytes = encode_png(image, with_alpha, compression);
  if (!bytes) return Error{bytes.error().code, path.string() + ": " + bytes.error().message};
  return write_file_atomically(path, *bytes);
}

Result<Image> decode_png(std::span<const std::byte> bytes) {
  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  if (bytes.empty() || !png_image_begin_read_from_memory(&header, bytes.data(), bytes.size())) {
    const std::string why = bytes.empty() ? "no bytes" : header.message;
    png_image_free(&header);
    return invalid_data("PNG: " + why);
  }
  const size_t count = static_cast<size_t>(header.width) * header.height;
  if (count > kMaxPngPixels || count / kMaxPixelsPerByte > bytes.size()) {
    const std::string size = std::to_string(header.width) + " x " + std::to_string(header.height);
    png_image_free(&header);
    if (count > kMaxPngPixels) {
      return Error{ErrorCode::TooLarge,
                   "PNG: " + size + " pixels are more than " + std::to_string(kMaxPngPixels)};
    }
    return invalid_data("PNG: " + size + " pixels cannot come from " + std::to_string(bytes.size()) +
                        " bytes");
  }
  // Without the flag 16-bit files would be taken for linear light.
  header.flags |= PNG_IMAGE_FLAG_16BIT_sRGB;
  header.format = PNG_FORMAT_RGBA;
  std::vector<uint8_t> values(4 * count);
  const bool whole = png_image_finish_read(&header, nullptr, values.data(), 0, nullptr) != 0;
  const std::string why = header.message;
  png_image_free(&header);
  if (!whole) return invalid_data("PNG: " + why);
  Image image;
  image.width = static_cast<int>(header.width);
  image.height = static_cast<int>(header.height);
  image.pixels.resize(values.size());
  for (size_t i = 0; i < values.size(); ++i) image.pixels[i] = static_cast<float>(values[i]) / 255.0f;
  return image;
}

Result<Image> read_png(const std::filesystem::path& path) {
  // No filter makes a row longer than its values and deflate adds under 1 %, so no useful file is larger.
  const Result<std::vector<std::byte>> bytes = read_file(path, 9 * kMaxPngPixels);
  if (!bytes) return bytes.error();
  Result<Image> image = decode_png(*bytes);
  if (!image) return Error{image.error().code, path.string() + ": " + image.error().message};
  return image;
}

}  // namespace livegs
