// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

#include "common/splat/synthetic_kernels.h"
#include "core/file.h"
#include "scratch_folder.h"
#include "splat/image.h"

namespace livegs {
namespace {

// 8-bit values, so that a round trip is exact.
Image noise(int width, int height, uint64_t seed) {
  synthetic::Random random(seed);
  Image image{width, height, std::vector<float>(4 * static_cast<size_t>(width) * height)};
  for (float& value : image.pixels)
    value = static_cast<float>(static_cast<int>(random.uniform(0, 256))) / 255.0f;
  return image;
}

std::filesystem::path scratch(const char* name) { return std::filesystem::path(::testing::TempDir()) / name; }

std::vector<std::byte> encoded(const Image& image, bool with_alpha = true, int compression = 6) {
  const ScratchFolder folder;  // tests run in parallel
  const auto path = folder / "a.png";
  EXPECT_TRUE(write_png(path, image, with_alpha, compression).has_value());
  return read_file(path).value();
}

uint32_t crc32(std::span<const std::byte> bytes) {
  uint32_t crc = ~0u;
  for (const std::byte byte : bytes) {
    crc ^= static_cast<uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

void put_big_endian(std::vector<std::byte>& bytes, size_t at, uint32_t value) {
  for (int i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>(value >> (24 - 8 * i));
}

// Changes width and height of IHDR, which follow the signature, a length and a name. Its checksum covers the
// name and 13 bytes.
std::vector<std::byte> claiming(std::vector<std::byte> png, uint32_t width, uint32_t height) {
  put_big_endian(png, 16, width);
  put_big_endian(png, 20, height);
  put_big_endian(png, 29, crc32(std::span(png).subspan(12, 17)));
  return png;
}

TEST(Png, RoundTrips) {
  const Image image = noise(37, 21, 1);
  for (const int compression : {0, 1, 5, 6, 9}) {
    const Result<Image> back = decode_png(encoded(image, true, compression));
    ASSERT_TRUE(back) << back.error().message;
    EXPECT_EQ(back->width, 37);
    EXPECT_EQ(back->height, 21);
    EXPECT_EQ(back->pixels, image.pixels) << "compression " << compression;
  }
}

TEST(Png, WithoutAlphaIsOpaque) {
  Image image = noise(5, 4, 2);
  const Result<Image> back = decode_png(encoded(image, false));
  ASSERT_TRUE(back);
  for (size_t i = 3; i < image.pixels.size(); i += 4) image.pixels[i] = 1.0f;
  EXPECT_EQ(back->pixels, image.pixels);
}

TEST(Png, HigherCompressionIsSmaller) {
  Image image{200, 200, std::vector<float>(160'000, 0.25f)};
  EXPECT_GT(encoded(image, false, 0).size(), 120'000u);
  EXPECT_LT(encoded(image, false, 1).size(), 2'000u);
}

TEST(Png, TruncationIsAnError) {
  const std::vector<std::byte> whole = encoded(noise(16, 16, 3));
  constexpr size_t kEndChunk = 12;  // a missing IEND loses no pixel
  for (size_t size = 0; size < whole.size() - kEndChunk; ++size) {
    const Result<Image> image = decode_png(std::span(whole).first(size));
    // Only the last bytes of the stream, its checksums, may be missing without loss.
    if (image) {
      EXPECT_GT(size, whole.size() - kEndChunk - 10) << size;
      EXPECT_EQ(image->pixels.size(), 4u * 16 * 16);
    }
  }
}

TEST(Png, DamagedBytesNeverCrash) {
  const std::vector<std::byte> whole = encoded(noise(16, 16, 4));
  synthetic::Random random(5);
  for (int i = 0; i < 3000; ++i) {
    std::vector<std::byte> damaged = whole;
    for (int k = 0; k < 3; ++k) {
      damaged[static_cast<size_t>(random.uniform(0, static_cast<double>(damaged.size())))] =
          static_cast<std::byte>(random.uniform(0, 256));
    }
    const Result<Image> image = decode_png(damaged);
    if (image) {
      EXPECT_EQ(image->pixels.size(), 4 * static_cast<size_t>(image->width) * image->height);
    }
  }
}

TEST(Png, RejectsAnImpossibleSize) {
  const std::vector<std::byte> small = encoded(noise(4, 4, 6));
  const Result<Image> tall = decode_png(claiming(small, 8000, 4000));
  ASSERT_FALSE(tall);
  EXPECT_EQ(tall.error().code, ErrorCode::InvalidData);
  const Result<Image> vast = decode_png(claiming(small, 100'000, 100'000));
  ASSERT_FALSE(vast);
  EXPECT_EQ(vast.error().code, ErrorCode::TooLarge);
}

TEST(Png, RejectsOtherFiles) {
  const char text[] = "this is not a picture";
  EXPECT_FALSE(decode_png(std::as_bytes(std::span(text))));
  EXPECT_FALSE(decode_png({}));
}

TEST(Png, ErrorsContainTheFileName) {
  const auto path = scratch("livegs_not_a.png");
  ASSERT_TRUE(write_file_atomically(path, std::string_view("plain words")));
  const Result<Image> image = read_png(path);
  std::filesystem::remove(path);
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().message.find("livegs_not_a.png"), std::string::npos);
  const Result<Image> absent = read_png(scratch("livegs_absent.png"));
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().code, ErrorCode::NotFound);
}

TEST(Png, RejectsWritingAnInvalidImage) {
  EXPECT_FALSE(write_png(scratch("x.png"), Image{}));
  EXPECT_FALSE(write_png(scratch("x.png"), Image{2, 2, std::vector<float>(3)}));
  EXPECT_FALSE(write_png(scratch("x.png"), noise(2, 2, 1), false, 10));
}

// Grey, palette, 16-bit and RGBA files from other programs.
TEST(Png, ReadsTheSharedImages) {
  const std::filesystem::path folder(LIVEGS_SHARED_DATA_DIR);
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "shared data is not here";
  int count = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() != ".png" || ++count > 60) continue;
    const Result<Image> image = read_png(entry.path());
    EXPECT_TRUE(image) << (image ? "" : image.error().message);
  }
  EXPECT_GT(count, 0);
}

}  // namespace
}  // namespace livegs
