// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "common/gaussian/asset/expect_invariants.h"
#include "common/gaussian/differences.h"
#include "common/gaussian/synthetic_asset.h"
#include "gaussian/asset/y_up.h"
#include "gaussian/asset_file.h"

namespace livegs {
namespace {

AssetFile round_trip(const GaussianAsset& asset, const SpzOptions& options) {
  const Result<std::vector<std::byte>> bytes = encode_spz(asset, options);
  EXPECT_TRUE(bytes) << bytes.error().message;
  Result<AssetFile> file = decode_asset(*bytes, "round.spz");
  EXPECT_TRUE(file) << file.error().message;
  return std::move(*file);
}

// Half a step of each quantiser, plus a relative 1e-5 for float arithmetic.
constexpr float kSlack = 1e-5f;
constexpr float kPositionBound = 1.0f / 8192 + kSlack;
constexpr float kLogScaleBound = 1.0f / 32 + kSlack;
constexpr float kOpacityBound = 0.5f / 255 + kSlack;
constexpr float kDcBound = 0.5f / 255 / 0.15f + kSlack;
// Half a bucket of 8 or 16 steps, plus half a step for the earlier rounding.
constexpr float kSh1Bound = 4.5f / 128 + kSlack;
constexpr float kShRestBound = 8.5f / 128 + kSlack;
// Three components have an error of half a step of 1 / (511 sqrt 2). The largest component, at least 1/2, is
// derived from them, which at most doubles the error of the direction. An angle is twice that of its
// quaternion.
const float kSmallestThreeBoundDeg =
    static_cast<float>(2 * 2 * std::sqrt(3.0) * 0.5 / (511 * std::sqrt(2.0)) * 180 / M_PI);

TEST(Spz, RoundTripStaysWithinTheQuantiser) {
  for (const int version : {2, 3, 4}) {
    for (int degree = 0; degree <= 3; ++degree) {
      GaussianAsset asset = synthetic_asset(2000, degree, 10 + static_cast<uint64_t>(degree));
      asset.antialiased = degree == 2;
      const AssetFile file = round_trip(asset, {.version = version});
      ASSERT_EQ(file.asset.size(), asset.size());
      EXPECT_EQ(file.format_version, version);
      EXPECT_TRUE(file.y_up_in_file);
      EXPECT_EQ(file.asset.sh_degree, degree);
      EXPECT_EQ(file.asset.antialiased, asset.antialiased);
      expect_invariants(file.asset, "round trip");
      const Differences worst = differences(asset, file.asset, same_order(asset.size()));
      EXPECT_LE(worst.position, kPositionBound);
      EXPECT_LE(worst.log_scale, kLogScaleBound);
      EXPECT_LE(worst.opacity, kOpacityBound);
      EXPECT_LE(worst.sh_dc, kDcBound);
      EXPECT_LE(worst.sh1, kSh1Bound);
      EXPECT_LE(worst.sh_rest, kShRestBound);
      if (version >= 3) {
        EXPECT_LE(worst.rotation_deg, kSmallestThreeBoundDeg);
      }
    }
  }
}

// Version 2 stores x y z to half a step of 2/255 and derives w. The error of w, q.dq / w, diverges towards
// half turns; it is at most sqrt(2 |q| sqrt(3) / 255).
TEST(Spz, VersionTwoRotationsAreCoarseNearHalfTurns) {
  const GaussianAsset asset = synthetic_asset(5000, 0, 20);
  const AssetFile file = round_trip(asset, {.version = 2});
  const double step = std::sqrt(3.0) / 255;
  for (size_t i = 0; i < asset.size(); ++i) {
    const Eigen::Quaterniond a = asset.rotations[i].cast<double>(),
                             b = file.asset.rotations[i].cast<double>();
    const double w = std::abs(a.w());
    const double w_error = w * w > 4 * step ? 2 * step / w : std::sqrt(6 * step);
    const double angle_rad = a.angularDistance(b);
    EXPECT_LE(angle_rad, 2 * std::hypot(step, w_error) * 1.1) << "w = " << w;
  }
}

TEST(Spz, CanKeepAllBitsOfSh) {
  const GaussianAsset asset = synthetic_asset(500, 3, 30);
  const AssetFile file = round_trip(asset, {.sh1_bits = 8, .sh_rest_bits = 8});
  const Differences worst = differences(asset, file.asset, same_order(asset.size()));
  EXPECT_LE(worst.sh1, 0.5f / 128 + kSlack);
  EXPECT_LE(worst.sh_rest, 0.5f / 128 + kSlack);
}

TEST(Spz, SecondWriteIsIdempotent) {
  for (const int version : {3, 4}) {
    const AssetFile once = round_trip(synthetic_asset(500, 3, 40), {.version = version});
    const AssetFile twice = round_trip(once.asset, {.version = version});
    const Differences worst = differences(once.asset, twice.asset, same_order(once.asset.size()));
    EXPECT_EQ(worst.position, 0);
    EXPECT_EQ(worst.log_scale, 0);
    EXPECT_EQ(worst.sh_dc, 0);
    EXPECT_EQ(worst.sh1, 0);
    EXPECT_EQ(worst.sh_rest, 0);
  }
}

TEST(Spz, WideAssetsUseFewerFractionalBits) {
  GaussianAsset asset = synthetic_asset(50, 0, 50);
  asset.positions[7] = {-100000, 5, 5};
  const AssetFile file = round_trip(asset, {});
  // 100000 * 2^6 is the largest that fits 2^23.
  EXPECT_LE(differences(asset, file.asset, same_order(asset.size())).position, 1.0f / 128);
  EXPECT_EQ(file.asset.positions[7].x(), -100000);
  asset.positions[7].x() = 1e7f;
  EXPECT_EQ(encode_spz(asset).error().code, ErrorCode::InvalidArgument);
}

TEST(Spz, RejectsInvalidOptions) {
  const GaussianAsset asset = synthetic_asset(5, 0, 60);
  EXPECT_FALSE(encode_spz(asset, {.version = 1}));
  EXPECT_FALSE(encode_spz(asset, {.version = 5}));
  EXPECT_FALSE(encode_spz(asset, {.fractional_bits = 25}));
  EXPECT_FALSE(encode_spz(asset, {.sh1_bits = 0}));
  EXPECT_FALSE(encode_spz(GaussianAsset{}));
}

// The SH basis of Kerbl et al. 2023 with its signs, degrees 1 to 3.
std::array<double, 15> sh_basis(const Eigen::Vector3d& d) {
  const double x = d.x(), y = d.y(), z = d.z(), xx = x * x, yy = y * y, zz = z * z;
  return {-0.48860251 * y,
          0.48860251 * z,
          -0.48860251 * x,
          1.09254843 * x * y,
          -1.09254843 * y * z,
          0.31539157 * (2 * zz - xx - yy),
          -1.09254843 * x * z,
          0.54627422 * (xx - yy),
          -0.59004359 * y * (3 * xx - yy),
          2.89061144 * x * y * z,
          -0.45704580 * y * (4 * zz - xx - yy),
          0.37317633 * z * (2 * zz - 3 * xx - 3 * yy),
          -0.45704580 * x * (4 * zz - xx - yy),
          1.44530572 * z * (xx - yy),
          -0.59004359 * x * (xx - 3 * yy)};
}

Eigen::Vector3d colour(const GaussianAsset& asset, size_t i, const Eigen::Vector3d& direction) {
  Eigen::Vector3d rgb = Eigen::Vector3d::Constant(0.5) + 0.28209479 * asset.sh_dc[i].cast<double>();
  const std::array<double, 15> basis = sh_basis(direction);
  for (size_t k = 0; k < asset.sh_rest_count(); ++k)
    rgb += basis[k] * asset.sh_rest[i * asset.sh_rest_count() + k].cast<double>();
  return rgb;
}

TEST(YUp, RotatedAssetLooksTheSameInRotatedView) {
  const GaussianAsset asset = synthetic_asset(50, 3, 70);
  GaussianAsset turned = asset;
  turn_half_about_x(turned);
  const Eigen::Matrix3d turn = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const GaussianAsset directions = synthetic_asset(40, 0, 71);
  for (size_t i = 0; i < asset.size(); ++i) {
    EXPECT_EQ(turned.positions[i].cast<double>(), turn * asset.positions[i].cast<double>());
    for (const Eigen::Vector3f& position : directions.positions) {
      const Eigen::Vector3d direction = position.cast<double>().normalized();
      // Signs are exact; only the summation order of doubles differs.
      EXPECT_LT((colour(asset, i, direction) - colour(turned, i, turn * direction)).norm(), 1e-12);
    }
    // The covariance rotates too: R' S R'^T = T (R S R^T) T^T.
    const auto covariance = [&](const GaussianAsset& a) -> Eigen::Matrix3d {
      const Eigen::Matrix3d rs = a.rotations[i].cast<double>().toRotationMatrix() *
                                 a.log_scales[i].cast<double>().array().exp().matrix().asDiagonal();
      return rs * rs.transpose();
    };
    EXPECT_LT((covariance(turned) - turn * covariance(asset) * turn.transpose()).norm(),
              1e-12 * covariance(asset).norm());
  }
  turn_half_about_x(turned);
  EXPECT_EQ(turned.sh_rest, asset.sh_rest);
  EXPECT_EQ(turned.positions, asset.positions);
}

}  // namespace
}  // namespace livegs
