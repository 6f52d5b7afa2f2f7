// SPDX-License-Identifier: Apache-2.0
#include "splat/raster/bin_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "common/splat/synthetic_kernels.h"

namespace livegs {
namespace {

ProjectedKernel ellipse(double x, double y, double long_px, double short_px, double angle, double opacity) {
  const double c = std::cos(angle), s = std::sin(angle);
  const double yy = long_px * long_px * s * s + short_px * short_px * c * c;
  const double xy = (long_px * long_px - short_px * short_px) * c * s;
  const double det = long_px * long_px * short_px * short_px, scale = std::sqrt(0.5 * M_LOG2E);
  ProjectedKernel kernel{};
  kernel.centre_x_px = static_cast<float>(x);
  kernel.centre_y_px = static_cast<float>(y);
  kernel.across_x = static_cast<float>(scale * std::sqrt(yy / det));
  kernel.across_y = static_cast<float>(-scale * xy / std::sqrt(yy * det));
  kernel.down_y = static_cast<float>(scale / std::sqrt(yy));
  kernel.log2_opacity = static_cast<float>(std::log2(opacity));
  return kernel;
}

double alpha_at(const ProjectedKernel& k, int x, int y) {
  const double dx = x + 0.5 - k.centre_x_px, dy = y + 0.5 - k.centre_y_px;
  const double u = k.across_x * dx + k.across_y * dy, v = k.down_y * dy;
  return std::exp2(k.log2_opacity - u * u - v * v);
}

std::vector<ProjectedKernel> random_ellipses(size_t count, uint64_t seed) {
  synthetic::Random random(seed);
  std::vector<ProjectedKernel> kernels;
  for (size_t i = 0; i < count; ++i) {
    const double size = std::exp(random.uniform(-0.6, 4.0));
    kernels.push_back(ellipse(random.uniform(-60, 220), random.uniform(-60, 180), size,
                              std::max(0.55, size * random.uniform(0.01, 1)), random.uniform(0, M_PI),
                              random.uniform(0.01, 1.0)));
  }
  return kernels;
}

constexpr TileGrid kGrid{150, 100};  // neither side is a multiple of the tile size

TEST(BinTiles, CoverEveryVisibleTile) {
  const std::vector<ProjectedKernel> kernels = random_ellipses(400, 1);
  for (const ProjectedKernel& kernel : kernels) {
    for (int y = 0; y < kGrid.height; ++y) {
      const TileSpan span = ellipse_tile_span(kernel, kGrid, y / kTileSize);
      for (int x = 0; x < kGrid.width; ++x) {
        // Slightly above the threshold, where float rounding would decide.
        if (alpha_at(kernel, x, y) < 1.001 / 255.0) continue;
        ASSERT_TRUE(x / kTileSize >= span.first && x / kTileSize <= span.last) << x << " " << y;
      }
    }
  }
}

// The bins use the ellipse, not its bounding box: a thin diagonal kernel touches few tiles of its box.
TEST(BinTiles, CoverFewTilesOfADiagonalNeedle) {
  const ProjectedKernel needle = ellipse(75, 50, 30, 0.6, 0.6, 0.9);
  int tiles = 0;
  for (int row = 0; row < kGrid.rows(); ++row) {
    const TileSpan span = ellipse_tile_span(needle, kGrid, row);
    tiles += std::max(0, span.last - span.first + 1);
  }
  EXPECT_LE(tiles,
            18);  // its box covers all 70; the line crosses 10 columns and 7 rows: 16 tiles and two corners
  EXPECT_GE(tiles, 10);
}

TEST(BinTiles, KeepTheGivenOrderInEachTile) {
  const std::vector<ProjectedKernel> kernels = random_ellipses(20'000, 2);
  std::vector<uint32_t> order(kernels.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<uint32_t>((i * 7919) % order.size());
  std::vector<size_t> place(kernels.size());
  for (size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  const std::vector<uint32_t> live(kGrid.size(), 1);
  TileBins bins;
  bins.fill(kernels, order, kGrid, live);
  size_t touches = 0;
  for (size_t tile = 0; tile < kGrid.size(); ++tile) {
    const auto bin = bins.of_tile(tile);
    touches += bin.size();
    for (size_t i = 1; i < bin.size(); ++i) ASSERT_LT(place[bin[i - 1]], place[bin[i]]);
  }
  EXPECT_GT(touches, kernels.size());
}

// The projection finds the tile of a small kernel.
TEST(BinTiles, KernelOfOneTileIsOnlyThere) {
  std::vector<ProjectedKernel> kernels = {ellipse(40, 24, 2, 1, 0.3, 0.9)};
  kernels[0].tile_bound = 1;
  kernels[0].tile = static_cast<uint32_t>(24 / kTileSize * kGrid.columns() + 40 / kTileSize);
  const std::vector<uint32_t> order = {0};
  std::vector<uint32_t> live(kGrid.size(), 1);
  TileBins bins;
  bins.fill(kernels, order, kGrid, live);
  for (size_t tile = 0; tile < kGrid.size(); ++tile)
    EXPECT_EQ(bins.of_tile(tile).size(), tile == kernels[0].tile ? 1u : 0u) << tile;
  live[kernels[0].tile] = 0;
  bins.fill(kernels, order, kGrid, live);
  EXPECT_TRUE(bins.of_tile(kernels[0].tile).empty());
}

TEST(BinTiles, LeaveFinishedTilesEmpty) {
  const std::vector<ProjectedKernel> kernels = random_ellipses(1000, 3);
  std::vector<uint32_t> order(kernels.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = static_cast<uint32_t>(i);
  std::vector<uint32_t> live(kGrid.size(), 1);
  live[12] = 0;
  TileBins bins;
  bins.fill(kernels, order, kGrid, live);
  EXPECT_TRUE(bins.of_tile(12).empty());
  EXPECT_FALSE(bins.of_tile(13).empty());
}

}  // namespace
}  // namespace livegs
