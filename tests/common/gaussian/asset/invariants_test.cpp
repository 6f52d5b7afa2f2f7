// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/synthetic_asset.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

AssetFile through_a_file(const GaussianAsset& asset) {
  Result<AssetFile> file = decode_asset(encode_ply(asset), "off.ply");
  EXPECT_TRUE(file) << file.error().message;
  return std::move(*file);
}

TEST(Invariants, DropInvalidKernelsAndKeepOthers) {
  const GaussianAsset good = synthetic_asset(9, 2, 1);
  GaussianAsset asset = good;
  asset.positions[0].y() = kNan;
  asset.positions[2].x() = 2e18f;
  asset.log_scales[3].z() = 44;
  asset.rotations[4].w() = kInfinity;
  asset.opacity_logits[5] = kNan;
  asset.sh_dc[6].x() = -kInfinity;
  asset.sh_rest[7 * 8 + 5].z() = kNan;
  const AssetFile file = through_a_file(asset);
  expect_invariants(file.asset, "off");
  ASSERT_EQ(file.asset.size(), 2u);
  for (const auto& [kept, original] : {std::pair<size_t, size_t>{0, 1}, {1, 8}}) {
    EXPECT_EQ(file.asset.positions[kept], good.positions[original]);
    EXPECT_EQ(file.asset.opacity_logits[kept], good.opacity_logits[original]);
    for (size_t k = 0; k < 8; ++k)
      EXPECT_EQ(file.asset.sh_rest[kept * 8 + k], good.sh_rest[original * 8 + k]);
  }
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("dropped 7 kernels"), std::string::npos) << file.notes[0];
}

TEST(Invariants, RejectAFileWithoutValidKernels) {
  GaussianAsset asset = synthetic_asset(3, 0, 2);
  for (float& logit : asset.opacity_logits) logit = kNan;
  EXPECT_EQ(decode_asset(encode_ply(asset), "off.ply").error().code, ErrorCode::InvalidData);
}

TEST(Invariants, InfiniteLogitsBecomeOpaqueAndClear) {
  GaussianAsset asset = synthetic_asset(2, 0, 3);
  asset.opacity_logits = {kInfinity, -kInfinity};
  const AssetFile file = through_a_file(asset);
  EXPECT_EQ(file.asset.opacity_logits, (std::vector<float>{16, -16}));
  // e^-16 is below one float rounding step at 1.
  EXPECT_NEAR(1 / (1 + std::exp(-file.asset.opacity_logits[0])), 1.0f, std::numeric_limits<float>::epsilon());
}

TEST(Invariants, FlatKernelsStayThin) {
  GaussianAsset asset = synthetic_asset(2, 0, 4);
  asset.log_scales[1].y() = -kInfinity;
  const AssetFile file = through_a_file(asset);
  EXPECT_EQ(file.asset.log_scales[1].y(), -43);
  EXPECT_EQ(file.asset.log_scales[1].x(), asset.log_scales[1].x());
  EXPECT_EQ(file.notes.size(), 1u);
}

TEST(Invariants, QuaternionsAreNormalised) {
  GaussianAsset asset = synthetic_asset(4, 0, 5);
  const Eigen::Quaternionf unit = asset.rotations[0];
  asset.rotations[0].coeffs() *= 7;
  asset.rotations[1].coeffs().setZero();
  asset.rotations[2].coeffs() *= 1e-30f;  // the square underflows
  asset.rotations[3].coeffs() *= 1e30f;
  const AssetFile file = through_a_file(asset);
  expect_invariants(file.asset, "normalised");
  EXPECT_TRUE(file.asset.rotations[0].coeffs().isApprox(unit.coeffs(), 1e-6f));
  EXPECT_EQ(file.asset.rotations[1].coeffs(), Eigen::Quaternionf::Identity().coeffs());
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_NE(file.notes[0].find("identity"), std::string::npos);
}

}  // namespace
}  // namespace livegs
