// SPDX-License-Identifier: Apache-2.0
#include "gaussian/progressive_asset.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/shared_data.h"
#include "common/gaussian/synthetic_asset.h"
#include "common/wire/mutations.h"
#include "gaussian/asset_file.h"
#include "gaussian/opacity.h"
#include "gaussian/progressive/column_codec.h"
#include "gaussian/progressive/progressive_layout.h"

namespace livegs {
namespace {

using Buffer = std::vector<std::byte>;

// The complete decoded asset; fails the test if there is none.
GaussianAsset decoded(const Buffer& bytes) {
  auto asset = decode_progressive(bytes);
  EXPECT_TRUE(asset) << asset.error().message;
  return asset ? std::move(*asset) : GaussianAsset{};
}

double contribution(const GaussianAsset& asset, size_t i) {
  const Eigen::Array3d s = asset.log_scales[i].cast<double>().array().exp();
  return static_cast<double>(opacity_of_logit(asset.opacity_logits[i])) *
         (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]);
}

// An asset with few distinct values, as decoded from a quantised file.
GaussianAsset of_few_values(size_t count) {
  GaussianAsset asset = synthetic_asset(count, 1, 3);
  const auto coarse = [](float& value) { value = std::round(value * 40) / 40; };
  for (auto& v : asset.log_scales) std::for_each(v.begin(), v.end(), coarse);
  for (auto& v : asset.sh_dc) std::for_each(v.begin(), v.end(), coarse);
  for (auto& v : asset.sh_rest) std::for_each(v.begin(), v.end(), coarse);
  return asset;
}

GaussianAsset all_alike(size_t count) {
  GaussianAsset asset = synthetic_asset(1, 3, 5);
  asset.positions.assign(count, asset.positions[0]);
  asset.log_scales.assign(count, asset.log_scales[0]);
  asset.rotations.assign(count, asset.rotations[0]);
  asset.opacity_logits.assign(count, asset.opacity_logits[0]);
  asset.sh_dc.assign(count, asset.sh_dc[0]);
  asset.sh_rest.assign(count * 15, Eigen::Vector3f::Zero());
  return asset;
}

TEST(ProgressiveAsset, RoundTripIsLossless) {
  std::vector<GaussianAsset> assets;
  for (const int degree : {0, 1, 2, 3}) {
    for (const size_t count : {1, 2, 1023, 1025, 9000})
      assets.push_back(synthetic_asset(count, degree, count));
  }
  assets.push_back(of_few_values(40'000));
  assets.push_back(all_alike(70'000));
  assets.push_back(synthetic_asset(100, 0, 1));
  assets.back().antialiased = true;
  assets.back().positions[3] = {-0.0f, 1e-42f, -3e18f};
  for (const GaussianAsset& asset : assets) {
    const Buffer sent = encode_progressive(asset);
    EXPECT_EQ(encode_ply(decoded(sent)), encode_ply(asset))
        << asset.size() << " kernels of degree " << asset.sh_degree;
    EXPECT_EQ(encode_progressive(asset), sent);
  }
}

// Each prefix has the largest contributions, with the values of the whole asset.
TEST(ProgressiveAsset, SendsLargestContributionsFirst) {
  const GaussianAsset asset = synthetic_asset(20'000, 2, 9);
  const Buffer sent = encode_progressive(asset);
  ProgressiveDecoder decoder;
  size_t blocks = 0;
  std::set<size_t> kernels_at_blocks;
  for (size_t at = 0; at < sent.size(); at += 1000) {
    ASSERT_TRUE(decoder.take(std::span(sent).subspan(at, std::min<size_t>(1000, sent.size() - at))));
    if (decoder.blocks() == blocks) continue;
    blocks = decoder.blocks();
    kernels_at_blocks.insert(decoder.arrived());
    const AssetPart part = decoder.part();
    expect_invariants(part.asset, "a part");
    ASSERT_EQ(part.asset.size(), decoder.arrived());
    ASSERT_EQ(part.indices.size(), decoder.arrived());
    double least = std::numeric_limits<double>::infinity();
    std::set<uint32_t> there;
    for (size_t i = 0; i < part.indices.size(); ++i) {
      const uint32_t index = part.indices[i];
      if (i > 0) {
        ASSERT_GT(index, part.indices[i - 1]);
      }
      there.insert(index);
      least = std::min(least, contribution(asset, index));
      ASSERT_EQ(part.asset.positions[i], asset.positions[index]);
      ASSERT_EQ(part.asset.log_scales[i], asset.log_scales[index]);
      ASSERT_EQ(part.asset.rotations[i].coeffs(), asset.rotations[index].coeffs());
      ASSERT_EQ(part.asset.opacity_logits[i], asset.opacity_logits[index]);
      ASSERT_EQ(part.asset.sh_dc[i], asset.sh_dc[index]);
    }
    for (uint32_t i = 0; i < asset.size(); ++i) {
      if (!there.contains(i)) {
        ASSERT_LE(contribution(asset, i), least);
      }
    }
    EXPECT_EQ(part.asset.sh_degree, decoder.arrived_harmonics() > 0 ? 2 : 0);
  }
  EXPECT_TRUE(decoder.complete());
  EXPECT_GE(kernels_at_blocks.size(), 5u);  // 1024, 3072, 7168, 15360, 20000
  // All kernels precede the higher harmonics, which are most of the bytes.
  ProgressiveDecoder quarter;
  ASSERT_TRUE(quarter.take(std::span(sent).first(sent.size() / 2)));
  EXPECT_EQ(quarter.arrived(), asset.size());
}

TEST(ProgressiveAsset, AcceptsBytesInAnyPieces) {
  const GaussianAsset asset = synthetic_asset(1500, 1, 2);
  const Buffer sent = encode_progressive(asset);
  ProgressiveDecoder decoder;
  for (size_t i = 0; i < sent.size(); ++i) {
    EXPECT_FALSE(decoder.complete());
    ASSERT_TRUE(decoder.take(std::span(sent).subspan(i, 1))) << i;
  }
  ASSERT_TRUE(decoder.complete());
  EXPECT_EQ(encode_ply(*decoder.whole()), encode_ply(asset));
  const Buffer more(1);
  EXPECT_FALSE(decoder.take(more));
  EXPECT_FALSE(decoder.take({}));
}

// Few distinct values and similar neighbours are compressed; noise is not expanded.
TEST(ProgressiveAsset, IsSmallerThanItsKernels) {
  const auto share = [](const GaussianAsset& asset) {
    const double floats = static_cast<double>(14 + 3 * asset.sh_rest_count());
    return static_cast<double>(encode_progressive(asset).size()) /
           (4 * floats * static_cast<double>(asset.size()));
  };
  EXPECT_LT(share(synthetic_asset(50'000, 0, 1)), 0.95);  // only exponents of noise compress
  EXPECT_LT(share(of_few_values(50'000)), 0.5);
  EXPECT_LT(share(all_alike(50'000)), 0.003);
}

TEST(ProgressiveAsset, SurvivesAnyBytes) {
  std::vector<Buffer> seeds = {encode_progressive(synthetic_asset(40, 0, 1)),
                               encode_progressive(synthetic_asset(1100, 1, 2)),
                               encode_progressive(of_few_values(1500)), encode_progressive(all_alike(3000))};
  const auto look = [](std::span<const std::byte> bytes) {
    ProgressiveDecoder decoder;
    const auto taken = decoder.take(bytes.first(bytes.size() / 2));
    const AssetPart part = decoder.part();
    if (part.asset.size() > 0) expect_invariants(part.asset, "a part");
    if (taken) (void)decoder.take(bytes.subspan(bytes.size() / 2));
    if (decoder.complete()) (void)decoder.whole();
    (void)decode_progressive(bytes);
  };
  for (size_t i = 0; i < seeds.size(); ++i) testing::for_each_mutation(seeds[i], 3000, i, look);
  const Buffer& small = seeds[0];
  for (size_t length = 0; length < small.size(); ++length) {
    EXPECT_FALSE(decode_progressive(std::span(small).first(length))) << length;
  }
}

TEST(ProgressiveAsset, RejectsInvalidHeadersAndBlocks) {
  const Buffer good = encode_progressive(synthetic_asset(1200, 0, 4));
  const auto refused = [&](size_t at, std::initializer_list<int> values) {
    Buffer bytes = good;
    for (const int value : values) bytes[at++] = static_cast<std::byte>(value);
    const auto asset = decode_progressive(bytes);
    EXPECT_FALSE(asset) << at;
    return asset ? std::string() : asset.error().message;
  };
  EXPECT_NE(refused(6, {2}).find("wrong magic number or version"), std::string::npos);
  refused(8, {0, 0, 0, 0});               // no kernels
  refused(8, {0xFF, 0xFF, 0xFF, 0xFF});   // over 4 GiB
  refused(8, {0xB1, 0x04, 0, 0});         // one kernel too many
  refused(8, {0xAF, 0x04, 0, 0});         // one kernel too few
  refused(12, {4});                       // harmonics
  refused(13, {2});                       // a flag
  refused(14, {1});                       // reserved
  refused(16, {0, 0, 0, 0});              // an empty block
  refused(16, {0xFF, 0xFF, 0xFF, 0x7F});  // a block larger than its kernels
  refused(20, {0, 0, 0, 0});              // a block without kernels
  refused(20, {1, 0x80, 0, 0});           // a block of 32769 kernels
}

// A repeated kernel, which a checksum would not detect.
TEST(ProgressiveAsset, RejectsARepeatedKernel) {
  GaussianAsset one = all_alike(1), two = all_alike(2);
  for (GaussianAsset* asset : {&one, &two}) {
    asset->sh_degree = 0;
    asset->sh_rest.clear();
  }
  const Buffer block = encode_progressive(one);
  Buffer twice = encode_progressive(two);
  twice.resize(16);  // the head
  for (int i = 0; i < 2; ++i) twice.insert(twice.end(), block.begin() + 16, block.end());
  const auto refused = decode_progressive(twice);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("repeated"), std::string::npos) << refused.error().message;
}

// A kernel that violates the invariants is never drawn.
TEST(ProgressiveAsset, DropsInvalidKernels) {
  GaussianAsset asset = synthetic_asset(10, 1, 6);
  asset.positions[2].x() = std::nanf("");
  asset.rotations[3].coeffs() *= 2;
  asset.log_scales[4].y() = 90;
  asset.sh_rest[5 * 3].x() = std::numeric_limits<float>::infinity();
  ProgressiveDecoder decoder;
  ASSERT_TRUE(decoder.take(encode_progressive(asset)));
  EXPECT_EQ(decoder.part().indices, (std::vector<uint32_t>{0, 1, 6, 7, 8, 9}));
  EXPECT_EQ(encode_ply(*decoder.whole()), encode_ply(asset));
}

// proto/asset_format.md, "Worked example".
TEST(ProgressiveAsset, ReadsTheWorkedExample) {
  std::string text =
      "4C5647415354010A 02000000 00000000 90000000 02000000 28B52FFD 2087390400 "
      "000000000000000000 000000000080803F3F 01FFFFFFFFFFFF7F7F 0000000000408040BF";
  for (int i = 0; i < 3; ++i) text += "00000000008000C0C0";
  for (int i = 0; i < 3; ++i) text += "000000000000000000";
  text += "000000000080803F3F 000000000000000040 000000000000803F3F 000000000000003F00 000000000000003F00";
  std::erase(text, ' ');
  Buffer bytes;
  for (size_t i = 0; i < text.size(); i += 2)
    bytes.push_back(static_cast<std::byte>(std::stoi(text.substr(i, 2), nullptr, 16)));
  GaussianAsset expected;
  expected.resize(2);
  expected.positions = {{1, 2, 3}, {1, 0, -1}};
  expected.log_scales = {{-4, -4, -4}, {-2, -2, -2}};
  expected.rotations = {Eigen::Quaternionf::Identity(), Eigen::Quaternionf::Identity()};
  expected.opacity_logits = {0, 2};
  expected.sh_dc = {{0.5f, 0.5f, 0.5f}, {1, 0, 0}};
  EXPECT_EQ(encode_ply(decoded(bytes)), encode_ply(expected));
  EXPECT_EQ(encode_ply(decoded(encode_progressive(expected))), encode_ply(expected));
}

// proto/asset_format.md, "Columns".
TEST(ColumnCodec, UsesEachOfItsThreeModes) {
  std::vector<uint32_t> few(600), near(600), noise(600);
  std::mt19937 random(1);
  for (size_t i = 0; i < few.size(); ++i) {
    few[i] = std::array{0x3F800000u, 0x40000000u, 0xBF000000u, 0u}[random() % 4];
    near[i] = 0x3F000000u + static_cast<uint32_t>(3 * i + random() % 3);
    noise[i] = 0x3F800000u | (static_cast<uint32_t>(random()) & 0xFFFF);
  }
  const std::pair<const std::vector<uint32_t>*, int> cases[] = {{&noise, 0}, {&near, 1}, {&few, 2}};
  for (const auto& [words, way] : cases) {
    const ColumnBytes column = encode_column(*words);
    EXPECT_EQ(std::to_integer<int>(column.bytes[0]), way);
    EXPECT_EQ(column.ends.back(), column.bytes.size());
    EXPECT_LE(column.bytes.size(), max_column_bytes(words->size()));
    std::vector<uint32_t> back(words->size());
    std::span<const std::byte> bytes = column.bytes;
    ASSERT_TRUE(decode_column(bytes, back));
    EXPECT_TRUE(bytes.empty());
    EXPECT_EQ(back, *words);
  }
}

// Real captures: lossless transfer compared with the .ply. Quantised captures become small; trained floats
// compress little.
TEST(ProgressiveAsset, CapturesAreSmallerThanTheirPly) {
  LIVEGS_NEEDS_SHARED_DATA();
  const std::pair<const char*, double> captures[] = {{"guitar/guitar.compressed.ply", 0.58},
                                                     {"lego_house/lego_house_50k.ply", 0.14},
                                                     {"statues/angel.sog", 0.35},
                                                     {"camera_leica/leica-sofort-top8192.ply", 0.85},
                                                     {"ponytail_palm/ponytail_palm.splat", 0.55}};
  for (const auto& [name, most] : captures) {
    const auto file = read_asset(shared_data() / "splats" / name);
    ASSERT_TRUE(file) << file.error().message;
    const Buffer ply = encode_ply(file->asset), sent = encode_progressive(file->asset);
    const double share = static_cast<double>(sent.size()) / static_cast<double>(ply.size());
    std::printf("%s: %zu kernels, %zu bytes of .ply, %zu sent, %.2f\n", name, file->asset.size(), ply.size(),
                sent.size(), share);
    EXPECT_LT(share, most) << name;
    EXPECT_EQ(encode_ply(decoded(sent)), ply) << name;
  }
}

}  // namespace
}  // namespace livegs
