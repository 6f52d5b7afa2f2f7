// SPDX-License-Identifier: Apache-2.0
#include "web/content_coding.h"

#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

namespace livegs {
namespace {

TEST(ContentCoding, IsChosenByTheHeader) {
  EXPECT_EQ(choose_coding("gzip, deflate, br, zstd"), ContentCoding::Zstd);
  EXPECT_EQ(choose_coding("gzip;q=1.0, deflate"), ContentCoding::Gzip);
  EXPECT_EQ(choose_coding("zstd;q=0, gzip;q=0.5"), ContentCoding::Gzip);
  EXPECT_EQ(choose_coding("zstd; q=0.000,gzip;q=0"), ContentCoding::Identity);
  EXPECT_EQ(choose_coding(""), ContentCoding::Identity);
  EXPECT_EQ(choose_coding(",,;q=,x"), ContentCoding::Identity);
  EXPECT_TRUE(accepts_coding(" br ;q=0.1", "br"));
}

TEST(ContentCoding, KeepsTheBytes) {
  std::vector<std::byte> bytes(300'000);
  for (size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::byte>(i * i / 1000);
  const auto zstd = encode_content(bytes, ContentCoding::Zstd);
  ASSERT_TRUE(zstd);
  EXPECT_LT(zstd->size(), bytes.size() / 2);
  std::vector<std::byte> back(bytes.size());
  EXPECT_EQ(ZSTD_decompress(back.data(), back.size(), zstd->data(), zstd->size()), bytes.size());
  EXPECT_EQ(back, bytes);

  const auto gzip = encode_content(bytes, ContentCoding::Gzip);
  ASSERT_TRUE(gzip);
  std::fill(back.begin(), back.end(), std::byte{});
  z_stream stream{};
  ASSERT_EQ(inflateInit2(&stream, 15 + 16), Z_OK);  // 16: a header of gzip
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(gzip->data()));
  stream.avail_in = static_cast<uInt>(gzip->size());
  stream.next_out = reinterpret_cast<Bytef*>(back.data());
  stream.avail_out = static_cast<uInt>(back.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  inflateEnd(&stream);
  EXPECT_EQ(back, bytes);
}

}  // namespace
}  // namespace livegs
