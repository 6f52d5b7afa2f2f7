// SPDX-License-Identifier: Apache-2.0
// One asset in every format. All must decode to the same kernels within the quantisation error. The files
// come from an independent converter; most formats reorder, so kernels are matched by position.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/gaussian/differences.h"
#include "common/gaussian/shared_data.h"
#include "gaussian/asset_file.h"
#include "gaussian/asset_summary.h"

namespace livegs {
namespace {

// Maximum error of each property. 0 for a property whose mean is checked instead.
struct Bounds {
  float position;
  float log_scale;
  float rotation_deg;
  float opacity;
  float sh_dc;
  float sh1 = 0;
  float sh_rest = 0;
};

constexpr float kSlack = 2e-5f;  // float arithmetic on values up to 20
constexpr float kHalfByte = 0.5f / 255 + kSlack;

// Three components with an error of half a step each; spz_test.cpp derives the factor four.
float smallest_three_deg(double step) {
  return static_cast<float>(4 * std::sqrt(3.0) * step / 2 * 180 / M_PI);
}

const float kSpzRotationDeg = smallest_three_deg(1 / (511 * std::sqrt(2.0)));
const float kCompressedRotationDeg = smallest_three_deg(std::sqrt(2.0) / 1023);
// SOG writers truncate instead of rounding, which doubles the error to a whole step.
const float kSogRotationDeg = smallest_three_deg(2 * std::sqrt(2.0) / 255);

const Bounds kSpz = {1.0f / 8192 + kSlack, 1.0f / 32 + kSlack,  kSpzRotationDeg,    kHalfByte,
                     kHalfByte / 0.15f,    4.5f / 128 + kSlack, 8.5f / 128 + kSlack};

GaussianAsset asset_of(const std::string& name) {
  Result<AssetFile> file = read_asset(shared_data() / name);
  EXPECT_TRUE(file) << file.error().message;
  return file ? std::move(file->asset) : GaussianAsset{};
}

float widest(const std::vector<Eigen::Vector3f>& values) {
  Eigen::Vector3f low = values[0], high = values[0];
  for (const Eigen::Vector3f& value : values) low = low.cwiseMin(value), high = high.cwiseMax(value);
  return (high - low).maxCoeff();
}

// Half a step of a chunk as wide as the whole asset; the coarsest component has ten bits.
Bounds compressed_bounds(const GaussianAsset& a) {
  return {widest(a.positions) / 2046 + kSlack,
          widest(a.log_scales) / 2046 + kSlack,
          kCompressedRotationDeg,
          kHalfByte,
          widest(a.sh_dc) / 510 + kSlack,
          1.0f / 32 + kSlack,
          1.0f / 32 + kSlack};  // the outermost steps of SH are one and a half steps wide
}

// One step of the logarithm at the farthest kernel. Codebooks are bounded only in the mean.
Bounds sog_bounds(const GaussianAsset& a) {
  const AssetSummary s = summarise(a);
  float worst = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = s.bounds_min[axis], high = s.bounds_max[axis];
    const float range =
        std::copysign(std::log1p(std::abs(high)), high) - std::copysign(std::log1p(std::abs(low)), low);
    worst = std::max(worst, range / 65535 * (1 + std::max(std::abs(low), std::abs(high))));
  }
  return {worst + kSlack, 0, kSogRotationDeg, 1.0f / 255 + kSlack, 0};
}

// .spz stores log-scales from -10 to 255/16 - 10 and colours within +-1/0.3; other values are clamped.
GaussianAsset clamped_as_spz(GaussianAsset asset) {
  for (Eigen::Vector3f& scale : asset.log_scales) scale = scale.cwiseMax(-10.0f).cwiseMin(255.0f / 16 - 10);
  for (Eigen::Vector3f& dc : asset.sh_dc) dc = dc.cwiseMax(-0.5f / 0.15f).cwiseMin(0.5f / 0.15f);
  return asset;
}

void expect_same(const GaussianAsset& source, const std::string& name, const Bounds& bounds) {
  const GaussianAsset asset = asset_of(name);
  ASSERT_EQ(asset.size(), source.size()) << name;
  ASSERT_EQ(asset.sh_degree, source.sh_degree) << name;
  const std::vector<size_t> partner = match_by_position(source, asset, bounds.position);
  ASSERT_EQ(partner.size(), source.size()) << name << ": a kernel has no partner within " << bounds.position;
  const Differences worst = differences(source, asset, partner);
  EXPECT_LE(worst.position, bounds.position) << name;
  EXPECT_LE(worst.rotation_deg, bounds.rotation_deg) << name;
  EXPECT_LE(worst.opacity, bounds.opacity) << name;
  if (bounds.log_scale > 0) {
    EXPECT_LE(worst.log_scale, bounds.log_scale) << name;
    EXPECT_LE(worst.sh_dc, bounds.sh_dc) << name;
    EXPECT_LE(worst.sh1, bounds.sh1) << name;
    EXPECT_LE(worst.sh_rest, bounds.sh_rest) << name;
  } else {
    // A table of 256 values fitted to the data is on average at least as good as evenly spaced values.
    EXPECT_LE(worst.mean_log_scale, widest(source.log_scales) / 256 / 4) << name;
    EXPECT_LE(worst.mean_sh_dc, widest(source.sh_dc) / 256 / 4) << name;
  }
}

TEST(FormatMatrix, PalmWithoutSh) {
  LIVEGS_NEEDS_SHARED_DATA();
  const GaussianAsset source = asset_of("splats/ponytail_palm/ponytail_palm.ply");
  expect_same(source, "format_matrix/palm_sh0.compressed.ply", compressed_bounds(source));
  expect_same(source, "format_matrix/palm_sh0.sog", sog_bounds(source));
  expect_same(clamped_as_spz(source), "format_matrix/palm_sh0_v3.spz", kSpz);
  expect_same(clamped_as_spz(source), "format_matrix/palm_sh0_v4.spz", kSpz);
}

TEST(FormatMatrix, CameraWithShOfDegreeThree) {
  LIVEGS_NEEDS_SHARED_DATA();
  const GaussianAsset source = asset_of("splats/camera_leica/leica-sofort-top8192.ply");
  expect_same(source, "format_matrix/leica_sh3.compressed.ply", compressed_bounds(source));
  expect_same(source, "format_matrix/leica_sh3.sog", sog_bounds(source));
  expect_same(source, "splats/camera_leica/leica-sofort-top8192.sog", sog_bounds(source));
  expect_same(clamped_as_spz(source), "format_matrix/leica_sh3_v3.spz", kSpz);
  expect_same(clamped_as_spz(source), "format_matrix/leica_sh3_v4.spz", kSpz);
}

// The error of a clustered SH palette is not bounded. But the entry must belong to its kernel: it is much
// nearer to it than to the next kernel of the file.
TEST(FormatMatrix, SogPaletteEntriesBelongToTheirKernels) {
  LIVEGS_NEEDS_SHARED_DATA();
  const GaussianAsset source = asset_of("splats/camera_leica/leica-sofort-top8192.ply");
  const GaussianAsset sog = asset_of("format_matrix/leica_sh3.sog");
  std::vector<size_t> partner = match_by_position(source, sog, sog_bounds(source).position);
  ASSERT_EQ(partner.size(), source.size());
  const double own = differences(source, sog, partner).mean_sh;
  std::rotate(partner.begin(), partner.begin() + 1, partner.end());
  EXPECT_LT(own, 0.5 * differences(source, sog, partner).mean_sh);
}

// Pairs unpacked by an independent decoder, in file order. Differences come only from float arithmetic and
// that decoder's clamping of opacities 0 and 1.
TEST(FormatMatrix, UnpackedPairsAgree) {
  LIVEGS_NEEDS_SHARED_DATA();
  struct Pair {
    const char* unpacked;
    const char* packed;
    float rotation_deg;
  };
  // .splat: the other decoder maps a quaternion byte b to 2b/255 - 1, this one to (b - 128)/128. Each
  // component differs by up to 1/128, and an angle is twice that of its quaternion.
  const Pair pairs[] = {
      {"splats/guitar/guitar.ply", "splats/guitar/guitar.compressed.ply", 0.01f},
      {"splats/ponytail_palm/ponytail_palm.ply", "splats/ponytail_palm/ponytail_palm.splat", 1.8f},
      {"splats/statues/angel.ply", "splats/statues/angel.sog", 0.01f}};
  for (const auto& [unpacked, packed, rotation_deg] : pairs) {
    const GaussianAsset a = asset_of(unpacked), b = asset_of(packed);
    ASSERT_EQ(a.size(), b.size());
    const Differences worst = differences(a, b, same_order(a.size()));
    EXPECT_LE(worst.position, 1e-5f) << packed;
    EXPECT_LE(worst.log_scale, 1e-5f) << packed;
    EXPECT_LE(worst.opacity, 1e-3f) << packed;
    EXPECT_LE(worst.sh_dc, 1e-5f) << packed;
    EXPECT_LE(worst.rotation_deg, rotation_deg) << packed;
  }
}

// Small assets with values on the grid of every quantiser ("exact") or off it.
TEST(FormatMatrix, EquivalenceFixtures) {
  LIVEGS_NEEDS_SHARED_DATA();
  const GaussianAsset exact = asset_of("fixtures/equivalence/equiv-degree3-exact-binary-le.ply");
  for (const char* name : {"exact-v2.spz", "exact-v3.spz", "exact.sog"}) {
    const GaussianAsset other = asset_of(std::string("fixtures/equivalence/equiv-degree3-") + name);
    ASSERT_EQ(other.size(), exact.size());
    const Differences worst = differences(exact, other, same_order(exact.size()));
    EXPECT_LE(worst.position, 1e-4f) << name;
    EXPECT_LE(worst.log_scale, 1e-4f) << name;
    EXPECT_LE(worst.opacity, kHalfByte) << name;
    EXPECT_LE(worst.sh_dc, 1e-4f) << name;
    EXPECT_LE(worst.sh1, 1e-4f) << name;
    EXPECT_LE(worst.sh_rest, 1e-4f) << name;
    EXPECT_LE(worst.rotation_deg, kSogRotationDeg) << name;
  }
  const GaussianAsset source = asset_of("fixtures/equivalence/equiv-degree1-offgrid-binary-le.ply");
  const GaussianAsset spz = asset_of("fixtures/equivalence/equiv-degree1-offgrid-v2.spz");
  const Differences worst = differences(source, spz, same_order(source.size()));
  EXPECT_LE(worst.position, kSpz.position);
  EXPECT_LE(worst.log_scale, kSpz.log_scale);
  EXPECT_LE(worst.opacity, kSpz.opacity);
  EXPECT_LE(worst.sh_dc, kSpz.sh_dc);
  EXPECT_LE(worst.sh1, kSpz.sh1);
}

TEST(FormatMatrix, ThreePointsOfTrain) {
  LIVEGS_NEEDS_SHARED_DATA();
  const GaussianAsset source = asset_of("fixtures/misc/3-points-from-train.ply");
  const GaussianAsset spz = asset_of("fixtures/misc/3-points-from-train.spz");
  const Differences worst = differences(source, spz, same_order(source.size()));
  EXPECT_LE(worst.log_scale, kSpz.log_scale);
  EXPECT_LE(worst.opacity, kSpz.opacity);
  EXPECT_LE(worst.sh_dc, kSpz.sh_dc);
}

}  // namespace
}  // namespace livegs
