// SPDX-License-Identifier: Apache-2.0
// An asset to every format that is written, and back: within the steps that asset_file.h states, with the
// mark of antialiased training, the unit, the axis and the origin.
#include <gtest/gtest.h>

#include <cmath>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/differences.h"
#include "common/gaussian/synthetic_asset.h"
#include "gaussian/asset_file.h"
#include "gaussian/sog/codebook.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

constexpr float kRounding = 2e-5f;  // float arithmetic on values up to 20

float range_of(const std::vector<Eigen::Vector3f>& values) {
  Eigen::Vector3f low = values[0], high = values[0];
  for (const Eigen::Vector3f& value : values) low = low.cwiseMin(value), high = high.cwiseMax(value);
  return (high - low).maxCoeff();
}

// The kernels of an asset in the order of a file that has other ones: by position.
Differences compared(const GaussianAsset& asset, const GaussianAsset& back, float radius) {
  EXPECT_EQ(back.size(), asset.size());
  EXPECT_EQ(back.sh_degree, asset.sh_degree);
  const std::vector<size_t> partner = match_by_position(asset, back, radius);
  EXPECT_EQ(partner.size(), asset.size());
  return partner.size() == asset.size() ? differences(asset, back, partner) : Differences{.position = 1e9f};
}

GaussianAsset decoded(const Result<std::vector<std::byte>>& bytes, const std::string& name) {
  EXPECT_TRUE(bytes) << bytes.error().message;
  Result<AssetFile> file = decode_asset(*bytes, name);
  EXPECT_TRUE(file) << file.error().message;
  if (!file) return {};
  expect_invariants(file->asset, name);
  return std::move(file->asset);
}

TEST(RoundTrip, CompressedPlyStaysWithinItsSteps) {
  for (const size_t count : {1u, 2u, 255u, 256u, 257u, 3000u}) {
    for (int degree = 0; degree <= 3; ++degree) {
      GaussianAsset asset = synthetic_asset(count, degree, 20 + count);
      asset.antialiased = degree == 1;
      const GaussianAsset back = decoded(encode_compressed_ply(asset), "a.compressed.ply");
      EXPECT_EQ(back.antialiased, asset.antialiased);
      // A chunk is at most as wide as the whole asset.
      const float position = range_of(asset.positions) / 2046 + kRounding;
      const Differences worst = compared(asset, back, position);
      EXPECT_LE(worst.position, position);
      EXPECT_LE(worst.log_scale, range_of(asset.log_scales) / 2046 + kRounding);
      EXPECT_LE(worst.rotation_deg, 0.28f);
      EXPECT_LE(worst.opacity, 0.5f / 255 + kRounding);
      EXPECT_LE(worst.sh_dc, range_of(asset.sh_dc) / 510 + kRounding);
      EXPECT_LE(worst.sh1, 1.0f / 64 + kRounding);
      EXPECT_LE(worst.sh_rest, 1.0f / 64 + kRounding);
    }
  }
}

// Neighbours share a chunk, so steps become finer with the density.
TEST(RoundTrip, CompressedPlyChunksAreSmall) {
  const GaussianAsset asset = synthetic_asset(256 * 128, 0, 5);
  const GaussianAsset back = decoded(encode_compressed_ply(asset), "a.compressed.ply");
  const std::vector<size_t> partner = match_by_position(asset, back, 4.0f / 2046);
  ASSERT_EQ(partner.size(), asset.size());
  double sum = 0;
  for (size_t i = 0; i < partner.size(); ++i)
    sum += static_cast<double>(std::abs(back.positions[partner[i]].y() - asset.positions[i].y()));
  // With one chunk for all, the mean error would be a quarter of a step of 4/1023.
  EXPECT_LE(sum / static_cast<double>(partner.size()), 0.5 * 0.25 * 4 / 1023);
}

TEST(RoundTrip, CompressedPlyKeepsHarmonicsUpToFour) {
  GaussianAsset asset = synthetic_asset(400, 1, 5);
  for (size_t i = 0; i < asset.sh_rest.size(); ++i) asset.sh_rest[i].setConstant(-4 + 8 * float(i) / 1199);
  const GaussianAsset back = decoded(encode_compressed_ply(asset), "a.compressed.ply");
  EXPECT_LE(compared(asset, back, 4.0f / 2046 + kRounding).sh1, 3.0f / 128 + kRounding);
}

TEST(RoundTrip, SogStaysWithinItsSteps) {
  for (const size_t count : {1u, 2u, 65u, 3000u}) {
    for (int degree = 0; degree <= 3; ++degree) {
      GaussianAsset asset = synthetic_asset(count, degree, 40 + count);
      asset.antialiased = degree == 2;
      const GaussianAsset back = decoded(encode_sog(asset), "a.sog");
      EXPECT_EQ(back.antialiased, asset.antialiased);
      // ln(1 + |x|) is at most ln 3 on both sides of zero, and its slope at 2 is 1/3.
      const float position = 2 * std::log(3.0f) / 131070 * 3 + kRounding;
      const Differences worst = compared(asset, back, position);
      EXPECT_LE(worst.position, position);
      EXPECT_LE(worst.log_scale, range_of(asset.log_scales) / 128 + kRounding);
      EXPECT_LE(worst.mean_log_scale, range_of(asset.log_scales) / 128 / 4);
      EXPECT_LE(worst.rotation_deg, 1.11f);
      EXPECT_LE(worst.opacity, 0.5f / 255 + kRounding);
      EXPECT_LE(worst.sh_dc, range_of(asset.sh_dc) / 128 + kRounding);
      EXPECT_LE(worst.sh1, 1.8f / 128 + kRounding);
      EXPECT_LE(worst.sh_rest, 1.8f / 128 + kRounding);
    }
  }
}

TEST(RoundTrip, GlbIsExactToRounding) {
  EXPECT_EQ(encode_glb(GaussianAsset{}).error().code, ErrorCode::InvalidArgument);
  for (int degree = 0; degree <= 3; ++degree) {
    GaussianAsset asset = synthetic_asset(300, degree, 50);
    asset.antialiased = degree == 3;
    const GaussianAsset back = decoded(encode_glb(asset), "a.glb");
    EXPECT_EQ(back.antialiased, asset.antialiased);
    const Differences worst = compared(asset, back, kRounding);
    EXPECT_EQ(worst.position, 0);
    EXPECT_LE(worst.log_scale, 1e-6f);
    EXPECT_LE(worst.rotation_deg, 0.05f);  // float rounding of the angle's cosine
    EXPECT_LE(worst.opacity, 1e-6f);
    EXPECT_LE(worst.sh_dc, 0);
    EXPECT_LE(worst.sh1, 1e-6f);
    EXPECT_LE(worst.sh_rest, 1e-6f);
  }
}

// One far value and one extreme scale: the others keep their precision, since tables follow the values.
TEST(RoundTrip, SogTablesFollowTheValues) {
  GaussianAsset asset = synthetic_asset(2000, 0, 7);
  asset.log_scales[0].setConstant(-43);
  asset.log_scales[1].setConstant(40);
  const GaussianAsset back = decoded(encode_sog(asset), "a.sog");
  EXPECT_LE(compared(asset, back, 1e-3f).mean_log_scale, 10.0 / 128 / 4);  // of scales within 10
}

// More kernels than palette entries: groups of equal harmonics are exact to the table.
TEST(RoundTrip, SogGroupsEqualHarmonics) {
  GaussianAsset asset = synthetic_asset(70000, 1, 8);
  for (size_t i = 0; i < asset.size(); ++i) {
    for (size_t k = 0; k < 3; ++k) asset.sh_rest[3 * i + k].setConstant(0.1f * float((i + k) % 7));
  }
  const GaussianAsset back = decoded(encode_sog(asset), "a.sog");
  EXPECT_LE(compared(asset, back, 1e-3f).sh1, 0.6f / 128 + kRounding);
}

TEST(RoundTrip, SogIsTheSameEachTime) {
  const GaussianAsset asset = synthetic_asset(500, 2, 9);
  EXPECT_EQ(*encode_sog(asset), *encode_sog(asset));
}

TEST(Codebook, ErrorsAreBoundedAndSmallWhereValuesAre) {
  std::vector<float> values;
  for (int i = 0; i < 5000; ++i) values.push_back(std::sin(static_cast<float>(i)) * 0.1f);
  values.push_back(100);
  const Codebook book(values);
  double sum = 0;
  for (const float value : values) {
    const float error = std::abs(book.entries()[book.nearest(value)] - value);
    EXPECT_LE(error, 100.2f / 128);
    sum += static_cast<double>(error);
  }
  EXPECT_LE(sum / 5001, 0.2 / 128);
  EXPECT_EQ(Codebook({3.0f}).entries()[Codebook({3.0f}).nearest(3.0f)], 3.0f);
}

TEST(RoundTrip, SplatStaysWithinItsSteps) {
  GaussianAsset asset = synthetic_asset(3000, 0, 50);
  asset.rotations[0] = Eigen::Quaternionf(1, 0, 0, 0);
  asset.rotations[1] = Eigen::Quaternionf(0, -1, 0, 0);
  asset.rotations[2] = Eigen::Quaternionf(0, 0, 0.9999f, 0.01f).normalized();
  const GaussianAsset back = decoded(encode_splat(asset), "a.splat");
  const Differences worst = compared(asset, back, 1e-6f);
  EXPECT_EQ(worst.position, 0);
  EXPECT_LE(worst.log_scale, kRounding);
  EXPECT_LE(worst.rotation_deg, 1.1f);
  EXPECT_LE(worst.opacity, 0.5f / 255 + kRounding);
  EXPECT_LE(worst.sh_dc, 0.5f / 255 / kShBand0 + kRounding);  // colours within 0 to 1
}

// Every format that has a place for it keeps what is known and what is a guess.
TEST(RoundTrip, FramesSurviveEveryFormat) {
  GaussianAsset asset = synthetic_asset(100, 0, 60);
  asset.antialiased = true;
  const ScratchFolder folder;
  for (const double metres : {0.0, 1.0, 0.0254}) {
    for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(5e5, -5.4e6, 312)}) {
      AssetFrame frame;
      frame.up_axis = "-y";
      frame.metres_per_unit = metres;
      frame.origin = origin;
      GaussianAsset at = asset;
      AssetFrame now = frame;
      for (const char* file : {"a.ply", "a.SPZ", "a.compressed.ply", "b.spz", "a.glb", "a.sog", "c.ply",
                               "c.Sog", "d.spz", "b.Glb"}) {
        ASSERT_TRUE(write_asset(folder / file, at, now));
        const auto read = read_asset(folder / file);
        ASSERT_TRUE(read) << read.error().message;
        at = read->asset;
        now = read->frame;
        EXPECT_TRUE(at.antialiased) << file;
        EXPECT_EQ(now.metres_per_unit, metres) << file;
        EXPECT_EQ(now.origin, origin) << file;
        EXPECT_EQ(now.up_axis, "-y") << file;
        EXPECT_TRUE(read->notes.empty()) << file << read->notes[0];
        EXPECT_TRUE(losses_of_format(file, at, now).empty());
        const AssetFrame named = named_frame(folder / file);
        EXPECT_EQ(named.up_axis, "-y") << file;
        EXPECT_EQ(named.metres_per_unit, metres) << file;
        EXPECT_TRUE(named.origin.isZero(0)) << file;
      }
      EXPECT_LE(compared(asset, at, 0.02f).position, 0.02f);
      const size_t losses = losses_of_format("a.splat", at, now).size();
      EXPECT_EQ(losses, 2u);  // the mark, and axes with unit and origin
    }
  }
  EXPECT_EQ(named_frame(folder / "none.ply").up_axis, "");
  for (const int version : {2, 3, 4}) {
    const auto unknown = decode_asset(*encode_spz(asset, {.version = version}), "a.spz");
    EXPECT_EQ(unknown->frame.metres_per_unit, 0);
    AssetFrame metric;
    metric.metres_per_unit = 1;
    const auto metres = decode_asset(*encode_spz(asset, {.version = version}, metric), "a.spz");
    EXPECT_EQ(metres->frame.metres_per_unit, 1);
    EXPECT_TRUE(metres->frame.unit_of_format);
  }
}

}  // namespace
}  // namespace livegs
