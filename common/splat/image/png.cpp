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

// Maximum image size: 8192 x 4096 pixels, twice the widest eye buffer in each direction; 512 MiB as floats.
constexpr size_t kMaxPngPixels = size_t{1} << 25;

// Maximum pixels per file byte. Deflate expands a byte at most 1032 times (RFC 1951: 258 bytes per match of
// two bits), and a byte has at most 8 pixels.
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

// Only trivially destructible locals are allowed here, because libpng exits by longjmp.
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
  // Choosing among all five filters takes more time than deflate at level 1.
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
    return invalid_argument("PNG: compression " + std::to_string(compression) +
                            " is out of range; use 0 to 9");
  }
  if (image.width <= 0 || image.height <= 0 ||
      image.pixels.size() != 4 * static_cast<size_t>(image.width) * image.height) {
    return invalid_argument("PNG: an image of " + std::to_string(image.width) + " x " +
                            std::to_string(image.height) + " pixels with " +
                            std::to_string(image.pixels.size()) + " values cannot be written");
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
    const std::string why = bytes.empty() ? "the file is empty" : header.message;
    png_image_free(&header);
    return invalid_data("PNG: " + why);
  }
  const size_t count = static_cast<size_t>(header.width) * header.height;
  if (count > kMaxPngPixels || count / kMaxPixelsPerByte > bytes.size()) {
    const std::string size = std::to_string(header.width) + " x " + std::to_string(header.height);
    png_image_free(&header);
    if (count > kMaxPngPixels) {
      return Error{ErrorCode::TooLarge, "PNG: " + size + " pixels exceed the limit of " +
                                            std::to_string(kMaxPngPixels) + "; scale the picture down"};
    }
    return invalid_data("PNG: " + size + " pixels do not fit in " + std::to_string(bytes.size()) +
                        " bytes; copy the damaged file again");
  }
  // Without the flag, libpng treats 16-bit files as linear light.
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
  // Filters do not lengthen rows and deflate adds under 1 %, so no valid file is larger.
  const Result<std::vector<std::byte>> bytes = read_file(path, 9 * kMaxPngPixels);
  if (!bytes) return bytes.error();
  Result<Image> image = decode_png(*bytes);
  if (!image) return Error{image.error().code, path.string() + ": " + image.error().message};
  return image;
}

}  // namespace livegs
