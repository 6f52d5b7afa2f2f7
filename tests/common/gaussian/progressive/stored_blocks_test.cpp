// SPDX-License-Identifier: Apache-2.0
#include "gaussian/stored_blocks.h"

#include <gtest/gtest.h>

#include "common/gaussian/synthetic_asset.h"
#include "common/wire/mutations.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive/progressive_layout.h"
#include "gaussian/progressive_asset.h"

namespace livegs {
namespace {

std::vector<std::byte> stored(const std::vector<std::byte>& progressive) {
  auto bytes = store_blocks(progressive);
  EXPECT_TRUE(bytes) << bytes.error().message;
  return bytes ? *std::move(bytes) : std::vector<std::byte>();
}

TEST(StoredBlocks, TheNativeDecoderReadsTheSameAsset) {
  for (int degree = 0; degree <= 3; ++degree) {
    for (const size_t count : {size_t{1}, size_t{1500}, size_t{40'000}}) {
      const GaussianAsset asset = synthetic_asset(count, degree, 17);
      const auto decoded = decode_progressive(stored(encode_progressive(asset)));
      ASSERT_TRUE(decoded) << decoded.error().message;
      EXPECT_EQ(encode_ply(*decoded), encode_ply(asset)) << count << " kernels of degree " << degree;
    }
  }
}

TEST(StoredBlocks, PrefixesCanBeDrawn) {
  const std::vector<std::byte> bytes = stored(encode_progressive(synthetic_asset(5000, 1, 5)));
  ProgressiveDecoder decoder;
  size_t arrived = 0;
  for (size_t at = 0; at < bytes.size(); at += 4096) {
    ASSERT_TRUE(decoder.take(std::span(bytes).subspan(at, std::min<size_t>(4096, bytes.size() - at))));
    EXPECT_GE(decoder.arrived(), arrived);
    arrived = decoder.arrived();
  }
  EXPECT_TRUE(decoder.complete());
}

TEST(StoredBlocks, StoringAgainChangesNothing) {
  const std::vector<std::byte> once = stored(encode_progressive(synthetic_asset(3000, 2, 9)));
  EXPECT_EQ(stored(once), once);
}

TEST(StoredBlocks, EachTruncationIsAnErrorOrAnAssetThatIsIncomplete) {
  const std::vector<std::byte> bytes = encode_progressive(synthetic_asset(40, 1, 3));
  for (size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = store_blocks(std::span(bytes).first(size));
    if (cut) {
      EXPECT_FALSE(decode_progressive(*cut)) << size << " bytes";
    }
  }
}

TEST(StoredBlocks, HostileBytesAreRejectedOrStoredForTheDecoder) {
  const std::vector<std::byte> bytes = encode_progressive(synthetic_asset(300, 3, 7));
  testing::for_each_mutation(bytes, 3000, 11, [](std::span<const std::byte> spoilt) {
    const auto result = store_blocks(spoilt);
    if (result) (void)decode_progressive(*result);
  });
}

}  // namespace
}  // namespace livegs
