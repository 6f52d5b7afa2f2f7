// SPDX-License-Identifier: Apache-2.0
// The weights are those of FlashSplat (Shen et al. 2024, equation 6): alpha_i T_i of kernel i in a pixel.
#include "splat/kernel_view.h"

#include <Eigen/LU>
#include <bit>
#include <cmath>

#include "core/assert.h"
#include "core/parallel_for.h"
#include "splat/raster/blend_tiles.h"
#include "splat/raster/sorted_kernels.h"
#include "splat/raster/tile_runs.h"

namespace livegs {
namespace {

// Smallest deviation of a kernel for the depth, in pixel footprints at its centre. Smaller values lose
// precision in the inverse of a flat kernel, larger ones move the depth towards the centre of the kernel.
constexpr double kDepthFloor_px = 0.05;

struct alignas(32) KernelTile {
  float transmittance[kTilePixels];  // as in TileState
  float red[kTilePixels], green[kTilePixels], blue[kTilePixels];
  uint32_t kernel[kTilePixels];
};

// Blends one kernel into a run and returns alpha times transmittance per pixel.
struct RunWeights {
  Lanes weight;
  LaneMask crossed_half;
  bool finished;
};

RunWeights blend_run(const Lanes& alpha, Lanes& transmittance) {
  const Lanes before = transmittance;
  const LaneMask seen = (alpha >= kMinAlpha) & (before > 0.0f);
  const Lanes weight = alpha * before;
  const Lanes after = before - weight;
  const LaneMask stops = seen & (after < kMinTransmittance);
  const LaneMask adds = seen & ~stops;
  transmittance = adds ? after : (stops ? -before : before);
  return {adds ? weight : lanes(0.0f), adds & (before >= kHalfway) & (after < kHalfway),
          mask_bits(transmittance > 0.0f) == 0};
}

// Calls visit(kernel, run, weights) for each kernel of a bin and run that it reaches, nearest first.
template <class Visit>
void blend_bin(std::span<const ProjectedKernel> kernels, std::span<const uint32_t> bin, float tile_x,
               float tile_y, KernelTile& tile, uint32_t& live, Visit&& visit) {
  for (size_t i = 0; i < bin.size() && live != 0; ++i) {
    if (i + 8 < bin.size()) __builtin_prefetch(&kernels[bin[i + 8]]);
    const ProjectedKernel& kernel = kernels[bin[i]];
    const TileKernel placed(kernel, tile_x, tile_y);
    uint32_t runs = touched_runs(kernel, placed) & live;
    if (runs == 0) continue;
    const RunAlpha alpha_of(kernel, placed);
    for (; runs != 0; runs &= runs - 1) {
      const int run = std::countr_zero(runs);
      const RunWeights blended = blend_run(alpha_of(run), lanes_at(tile.transmittance + first_pixel_of(run)));
      if (blended.finished) live &= ~(uint32_t{1} << run);
      visit(kernel, run, blended, (runs & (runs - 1)) == 0);
    }
  }
}

}  // namespace

double greatest_response_depth_m(const Eigen::Vector3d& mean_m, const Eigen::Matrix3d& covariance_m2,
                                 const Eigen::Vector3d& ray, double floor_m) {
  const Eigen::Matrix3d wide = covariance_m2 + floor_m * floor_m * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d towards = wide.inverse() * ray;
  return towards.dot(mean_m) / towards.dot(ray);
}

struct KernelRasteriser::Buffers {
  SortedKernels sorted;
  std::vector<KernelTile> tiles;
  std::vector<uint32_t> live;
  std::vector<std::vector<LabelWeight>> of_tile;

  TileGrid begin(const DrawnObject& object, const Camera& camera, const RasteriseOptions& options);
};

TileGrid KernelRasteriser::Buffers::begin(const DrawnObject& object, const Camera& camera,
                                          const RasteriseOptions& options) {
  LIVEGS_ASSERT(camera.width > 0 && camera.height > 0);
  const uint32_t slot = 0;
  sorted.project(std::span(&object, 1), std::span(&slot, 1), camera, options);
  sorted.sort();
  const TileGrid grid{camera.width, camera.height};
  tiles.resize(grid.size());
  live.resize(grid.size());
  parallel_for(grid.size(), 64, [&](size_t first, size_t end) {
    for (size_t t = first; t < end; ++t) {
      const int columns = grid.width - static_cast<int>(t % grid.columns()) * kTileSize;
      const int rows = grid.height - static_cast<int>(t / grid.columns()) * kTileSize;
      live[t] = runs_inside(columns, rows);
      KernelTile& tile = tiles[t];
      std::fill_n(tile.red, kTilePixels, 0.0f);
      std::fill_n(tile.green, kTilePixels, 0.0f);
      std::fill_n(tile.blue, kTilePixels, 0.0f);
      std::fill_n(tile.kernel, kTilePixels, kNoKernel);
      for (int i = 0; i < kTilePixels; ++i)
        tile.transmittance[i] = i % kTileSize < columns && i / kTileSize < rows ? 1.0f : 0.0f;
    }
  });
  return grid;
}

KernelRasteriser::KernelRasteriser() : buffers_(std::make_unique<Buffers>()) {}
KernelRasteriser::~KernelRasteriser() = default;
KernelRasteriser::KernelRasteriser(KernelRasteriser&&) noexcept = default;
KernelRasteriser& KernelRasteriser::operator=(KernelRasteriser&&) noexcept = default;

void KernelRasteriser::draw(const DrawnObject& object, const Camera& camera, KernelView& view) {
  Buffers& b = *buffers_;
  const TileGrid grid = b.begin(object, camera, {});
  b.sorted.for_each_batch(
      grid, [&] { return std::span<const uint32_t>(b.live); },
      [&](std::span<const ProjectedKernel> kernels, const TileBins& bins) {
        parallel_for(grid.size(), kTilesPerBlock, [&](size_t begin, size_t end) {
          for (size_t t = begin; t < end; ++t) {
            KernelTile& tile = b.tiles[t];
            blend_bin(kernels, bins.of_tile(t), static_cast<float>(t % grid.columns() * kTileSize),
                      static_cast<float>(t / grid.columns() * kTileSize), tile, b.live[t],
                      [&](const ProjectedKernel& kernel, int run, const RunWeights& blended, bool) {
                        const int pixel = first_pixel_of(run);
                        lanes_at(tile.red + pixel) += blended.weight * kernel.red;
                        lanes_at(tile.green + pixel) += blended.weight * kernel.green;
                        lanes_at(tile.blue + pixel) += blended.weight * kernel.blue;
                        for (uint32_t half = mask_bits(blended.crossed_half); half != 0; half &= half - 1)
                          tile.kernel[pixel + std::countr_zero(half)] = kernel.kernel;
                      });
          }
        });
      });

  const size_t pixels = static_cast<size_t>(grid.width) * grid.height;
  view.width = view.image.width = grid.width;
  view.height = view.image.height = grid.height;
  view.kernel.resize(pixels);
  view.depth_m.resize(pixels);
  view.image.pixels.resize(4 * pixels);
  const Projection projection(camera);
  const PosedKernels& posed = *object.kernels;
  parallel_for(static_cast<size_t>(grid.height), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < static_cast<size_t>(grid.width); ++x) {
        const KernelTile& tile = b.tiles[y / kTileSize * grid.columns() + x / kTileSize];
        const size_t i = y % kTileSize * kTileSize + x % kTileSize, pixel = y * grid.width + x;
        float* rgba = &view.image.pixels[4 * pixel];
        rgba[0] = tile.red[i];
        rgba[1] = tile.green[i];
        rgba[2] = tile.blue[i];
        rgba[3] = 1.0f - std::abs(tile.transmittance[i]);
        const uint32_t k = view.kernel[pixel] = tile.kernel[i];
        view.depth_m[pixel] = std::numeric_limits<float>::infinity();
        if (k == kNoKernel) continue;
        const Eigen::Vector3d mean =
            projection.image_from_world * (posed.positions_m[k].cast<double>() - projection.position_m);
        const Symmetric3f& s = posed.covariances_m2[k];
        Eigen::Matrix3d covariance;
        covariance << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
        covariance = projection.image_from_world * covariance * projection.image_from_world.transpose();
        const Eigen::Vector3d ray(
            (static_cast<double>(x) + 0.5 - projection.centre_x_px) / projection.focal_x_px,
            (static_cast<double>(y) + 0.5 - projection.centre_y_px) / projection.focal_y_px, 1.0);
        const double depth_m = greatest_response_depth_m(
            mean, covariance, ray, kDepthFloor_px * mean.z() / std::max(projection.focal_x_px, 1.0));
        // The projection is linear about the centre, so the response of a wide kernel near the camera may lie
        // behind it.
        view.depth_m[pixel] = static_cast<float>(depth_m > projection.near_m ? depth_m : mean.z());
      }
    }
  });
}

void KernelRasteriser::weigh(const DrawnObject& object, const Camera& camera,
                             std::span<const uint16_t> labels, std::vector<LabelWeight>& weights) {
  LIVEGS_ASSERT(labels.size() == static_cast<size_t>(camera.width) * camera.height);
  Buffers& b = *buffers_;
  const TileGrid grid = b.begin(object, camera, {.max_sh_degree = 0});  // weights need no colours
  b.of_tile.resize(std::max(b.of_tile.size(), grid.size()));
  for (size_t t = 0; t < grid.size(); ++t) b.of_tile[t].clear();
  b.sorted.for_each_batch(
      grid, [&] { return std::span<const uint32_t>(b.live); },
      [&](std::span<const ProjectedKernel> kernels, const TileBins& bins) {
        parallel_for(grid.size(), kTilesPerBlock, [&](size_t begin, size_t end) {
          std::vector<uint32_t> names;
          uint8_t name_of[kTilePixels];
          float sums[kTilePixels];
          for (size_t t = begin; t < end; ++t) {
            if (bins.of_tile(t).empty()) continue;
            const size_t left = t % grid.columns() * kTileSize, top = t / grid.columns() * kTileSize;
            names.clear();
            for (int i = 0; i < kTilePixels; ++i) {
              const size_t x = left + i % kTileSize, y = top + i / kTileSize;
              name_of[i] = 0;
              if (x >= static_cast<size_t>(grid.width) || y >= static_cast<size_t>(grid.height)) continue;
              const uint32_t label = labels[y * grid.width + x];
              const auto found = std::find(names.begin(), names.end(), label);
              name_of[i] = static_cast<uint8_t>(found - names.begin());
              if (found == names.end()) names.push_back(label);
            }
            std::fill_n(sums, names.size(), 0.0f);
            std::vector<LabelWeight>& out = b.of_tile[t];
            Lanes total = lanes(0.0f);
            blend_bin(kernels, bins.of_tile(t), static_cast<float>(left), static_cast<float>(top), b.tiles[t],
                      b.live[t],
                      [&](const ProjectedKernel& kernel, int run, const RunWeights& blended, bool last) {
                        if (names.size() == 1) {
                          total += blended.weight;
                        } else {
                          const int pixel = first_pixel_of(run);
                          for (int lane = 0; lane < 8; ++lane)
                            sums[name_of[pixel + lane]] += blended.weight[lane];
                        }
                        if (!last) return;
                        if (names.size() == 1) {
                          for (int lane = 0; lane < 8; ++lane) sums[0] += total[lane];
                          total = lanes(0.0f);
                        }
                        for (size_t n = 0; n < names.size(); ++n) {
                          if (sums[n] > 0.0f) out.push_back({kernel.kernel, names[n], sums[n]});
                          sums[n] = 0.0f;
                        }
                      });
          }
        });
      });
  for (size_t t = 0; t < grid.size(); ++t)
    weights.insert(weights.end(), b.of_tile[t].begin(), b.of_tile[t].end());
}

}  // namespace livegs
