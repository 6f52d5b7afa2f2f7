// SPDX-License-Identifier: Apache-2.0
// Edits of assets: lossless, small, and robust against any bytes.
#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <random>

#include "common/gaussian/synthetic_asset.h"
#include "gaussian/asset_file.h"
#include "gaussian/progressive/compare_assets.h"
#include "gaussian/progressive_asset.h"
#include "gaussian/transform_asset.h"

namespace livegs {
namespace {

using Buffer = std::vector<std::byte>;
using Base = std::shared_ptr<const GaussianAsset>;

// The listed kernels of an asset, in this order.
GaussianAsset chosen(const GaussianAsset& from, const std::vector<uint32_t>& kernels) {
  GaussianAsset to;
  to.sh_degree = from.sh_degree;
  to.antialiased = from.antialiased;
  to.resize(kernels.size());
  const size_t rest = from.sh_rest_count();
  for (size_t i = 0; i < kernels.size(); ++i) {
    const size_t k = kernels[i];
    to.positions[i] = from.positions[k];
    to.log_scales[i] = from.log_scales[k];
    to.rotations[i] = from.rotations[k];
    to.opacity_logits[i] = from.opacity_logits[k];
    to.sh_dc[i] = from.sh_dc[k];
    for (size_t r = 0; r < rest; ++r) to.sh_rest[i * rest + r] = from.sh_rest[k * rest + r];
  }
  return to;
}

std::vector<uint32_t> range(uint32_t from, uint32_t to) {
  std::vector<uint32_t> all(to - from);
  std::iota(all.begin(), all.end(), from);
  return all;
}

std::vector<uint32_t> joined(std::vector<uint32_t> a, const std::vector<uint32_t>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// The asset that the edit makes of the base; empty if the bytes are refused.
std::optional<GaussianAsset> edited(const Base& base, const Buffer& edit) {
  ProgressiveDecoder decoder(base);
  if (!decoder.take(edit)) return std::nullopt;
  return decoder.whole();
}

void expect_edit(const GaussianAsset& base, const GaussianAsset& asset, const char* what) {
  const auto edit = encode_edit(base, asset);
  ASSERT_TRUE(edit) << what;
  const auto made = edited(std::make_shared<GaussianAsset>(base), *edit);
  ASSERT_TRUE(made) << what;
  EXPECT_EQ(encode_ply(*made), encode_ply(asset)) << what;
}

TEST(AssetEdit, IsLosslessInBothDirections) {
  for (const int degree : {0, 1, 3}) {
    const GaussianAsset all = synthetic_asset(5000, degree, 4);
    const auto whole = range(0, 5000);
    const std::vector<std::pair<const char*, std::vector<uint32_t>>> parts{
        {"the same", whole},
        {"without the first", range(1, 5000)},
        {"without the last", range(0, 4999)},
        {"without a run", joined(range(0, 1000), range(2500, 5000))},
        {"only the last", range(4999, 5000)},
        {"two halves exchanged", joined(range(2500, 5000), range(0, 2500))},
        {"each kernel twice", joined(whole, whole)}};
    for (const auto& [what, kernels] : parts) {
      const GaussianAsset part = chosen(all, kernels);
      expect_edit(all, part, what);
      expect_edit(part, all, what);
    }
  }
}

TEST(AssetEdit, IsLosslessForRandomEdits) {
  std::mt19937 random(7);
  const GaussianAsset pool = synthetic_asset(600, 1, 5);
  const auto draw = [&] {
    std::vector<uint32_t> kernels;
    for (uint32_t i = 0; i < 600; ++i) {
      if (random() % 3 > 0) kernels.push_back(i);
    }
    if (random() % 4 == 0) std::shuffle(kernels.begin() + 100, kernels.begin() + 200, random);
    return chosen(pool, kernels);
  };
  for (int i = 0; i < 100; ++i) expect_edit(draw(), draw(), "random");
}

// A thing of 2 % that is taken out of a room leaves its place to a few new kernels.
TEST(AssetEdit, TakesAsManyBytesAsItsChange) {
  const GaussianAsset pool = synthetic_asset(20'200, 2, 6);
  const GaussianAsset room = chosen(pool, range(0, 20'000));
  const GaussianAsset without =
      chosen(pool, joined(joined(range(0, 7000), range(7400, 20'000)), range(20'000, 20'200)));
  const auto edit = encode_edit(room, without);
  ASSERT_TRUE(edit);
  // 200 new kernels of 20 000, and one gap.
  EXPECT_LT(edit->size(), encode_progressive(without).size() / 80);
  const auto back = encode_edit(without, room);
  ASSERT_TRUE(back);
  EXPECT_LT(back->size(), encode_progressive(room).size() / 40);  // 400 kernels
  const AssetDifference difference = compare_assets(room, without);
  EXPECT_EQ(difference.runs.size(), 2u);
  EXPECT_EQ(difference.added.size(), 200u);
}

TEST(AssetEdit, NeedsCommonKernelsAndEqualForm) {
  const GaussianAsset asset = synthetic_asset(100, 1, 8);
  EXPECT_FALSE(encode_edit(synthetic_asset(100, 1, 9), asset)) << "no kernel in common";
  EXPECT_FALSE(encode_edit(synthetic_asset(100, 2, 8), asset)) << "another degree";
  GaussianAsset filtered = asset;
  filtered.antialiased = true;
  EXPECT_FALSE(encode_edit(filtered, asset));
}

TEST(AssetEdit, IsRefusedWithoutItsBase) {
  const GaussianAsset pool = synthetic_asset(300, 1, 10);
  const GaussianAsset base = chosen(pool, range(0, 200)), asset = chosen(pool, range(100, 300));
  const auto edit = encode_edit(base, asset);
  ASSERT_TRUE(edit);
  EXPECT_FALSE(edited(nullptr, *edit));
  EXPECT_FALSE(edited(std::make_shared<GaussianAsset>(chosen(pool, range(0, 150))), *edit)) << "too short";
  EXPECT_FALSE(edited(std::make_shared<GaussianAsset>(synthetic_asset(200, 0, 10)), *edit))
      << "another degree";
  // A whole asset is accepted with a base too.
  EXPECT_TRUE(edited(std::make_shared<GaussianAsset>(base), encode_progressive(asset)));
}

TEST(AssetEdit, ArrivesInAnyPiecesAndRefusesTruncation) {
  const GaussianAsset pool = synthetic_asset(300, 1, 11);
  const auto base = std::make_shared<GaussianAsset>(chosen(pool, range(0, 200)));
  const GaussianAsset asset = chosen(pool, range(100, 300));
  const Buffer edit = *encode_edit(*base, asset);
  ProgressiveDecoder decoder(base);
  for (size_t i = 0; i < edit.size(); ++i) {
    EXPECT_FALSE(decoder.whole());
    ASSERT_TRUE(decoder.take(std::span(edit).subspan(i, 1))) << i;
  }
  ASSERT_TRUE(decoder.whole());
  EXPECT_EQ(encode_ply(*decoder.whole()), encode_ply(asset));
  EXPECT_FALSE(decoder.take(Buffer(1)));
}

// Each byte is replaced in turn. The result is an error, or an asset of the announced size.
TEST(AssetEdit, SurvivesDamage) {
  const GaussianAsset pool = synthetic_asset(60, 1, 12);
  const auto base = std::make_shared<GaussianAsset>(chosen(pool, range(0, 40)));
  const Buffer edit = *encode_edit(*base, chosen(pool, joined(range(5, 20), range(25, 60))));
  for (size_t at = 0; at < edit.size(); ++at) {
    for (const unsigned value : {0x00u, 0x01u, 0x7Fu, 0x80u, 0xFFu}) {
      Buffer damaged = edit;
      damaged[at] = std::byte(value);
      ProgressiveDecoder decoder(base);
      if (!decoder.take(damaged)) continue;
      if (const auto whole = decoder.whole()) EXPECT_EQ(whole->size(), decoder.kernel_count());
    }
  }
}

}  // namespace
}  // namespace livegs
