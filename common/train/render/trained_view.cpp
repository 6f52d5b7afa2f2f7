// SPDX-License-Identifier: Apache-2.0
#include "train/render/trained_view.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/log.h"
#include "core/parallel_for.h"
#include "splat/raster/ellipse_rim.h"
#include "train/render/blend_tile.h"
#include "train/render/device_blender.h"

namespace livegs {
namespace {

constexpr size_t kProjectBlock = 512;  // kernels
constexpr size_t kTileBlock = 2;       // tiles
constexpr size_t kPixelBlock = 8192;   // pixels

TileGrid grid_of(const Camera& camera) { return {camera.width, camera.height}; }

// Calls visit(tile) for each tile that the ellipse may touch.
template <class Visit>
void for_each_tile(const ProjectedKernel& kernel, float rim_value, const TileGrid& grid, const Visit& visit) {
  const EllipseRim rim(kernel, rim_value);
  const TileSpan pixel_rows = rim.rows(grid);
  if (pixel_rows.first > pixel_rows.last) return;
  const int last_row = pixel_rows.last / kTileSize;
  for (int row = pixel_rows.first / kTileSize; row <= last_row; ++row) {
    const TileSpan span = rim.span(grid, row);
    for (int column = span.first; column <= span.last; ++column)
      visit(static_cast<uint32_t>(row * grid.columns() + column));
  }
}

// The part of the picture in a tile.
struct TilePlace {
  TilePlace(const TileGrid& grid, size_t tile)
      : x(static_cast<int>(tile) % grid.columns() * kTileSize),
        y(static_cast<int>(tile) / grid.columns() * kTileSize),
        columns(std::min(kTileSize, grid.width - x)),
        rows(std::min(kTileSize, grid.height - y)),
        width(grid.width) {}
  // Calls visit(index in the tile, index in the picture).
  template <class Visit>
  void for_each_pixel(const Visit& visit) const {
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column)
        visit(row * kTileSize + column,
              static_cast<size_t>(y + row) * static_cast<size_t>(width) + static_cast<size_t>(x + column));
    }
  }
  TileFrame frame() const { return {static_cast<float>(x), static_cast<float>(y)}; }
  int x, y, columns, rows, width;
};

void start_tile(const TilePlace& place, TilePixels& tile) {
  std::fill_n(tile.transmittance, kTilePixels, 0.0f);
  std::fill_n(tile.red, kTilePixels, 0.0f);
  std::fill_n(tile.green, kTilePixels, 0.0f);
  std::fill_n(tile.blue, kTilePixels, 0.0f);
  std::fill_n(tile.depth, kTilePixels, 0.0f);
  std::fill_n(tile.spread, kTilePixels, 0.0f);
  for (int row = 0; row < place.rows; ++row)
    std::fill_n(tile.transmittance + row * kTileSize, place.columns, 1.0f);
}

}  // namespace

void TrainedView::project(const KernelParameters& parameters) {
  const size_t count = parameters.size();
  const Projection projection(camera_);
  projected_.resize(count);
  visible_.resize(count);
  parallel_for(count, kProjectBlock, [&](size_t begin, size_t end) {
    for (size_t k = begin; k < end; ++k) {
      visible_[k] =
          project_trained(projection, parameters, k, options_.sh_degree, options_.cuts, projected_[k]);
    }
  });
  keys_.clear();
  for (size_t k = 0; k < count; ++k) {
    // Positive floats are ordered as their bits.
    if (visible_[k] != 0) keys_.push_back(uint64_t{std::bit_cast<uint32_t>(projected_[k].depth_m)} << 32 | k);
  }
  std::sort(keys_.begin(), keys_.end());
  order_.resize(keys_.size());
  kernels_.resize(keys_.size());
  parallel_for(keys_.size(), 4 * kProjectBlock, [&](size_t begin, size_t end) {
    for (size_t rank = begin; rank < end; ++rank) {
      order_[rank] = static_cast<uint32_t>(keys_[rank]);
      kernels_[rank] = projected_[order_[rank]];
    }
  });
}

void TrainedView::bin() {
  const TileGrid grid = grid_of(camera_);
  const float cut = std::log2(options_.cuts.min_alpha);
  pair_first_.assign(kernels_.size() + 1, 0);
  parallel_for(kernels_.size(), kProjectBlock, [&](size_t begin, size_t end) {
    for (size_t rank = begin; rank < end; ++rank) {
      uint32_t tiles = 0;
      for_each_tile(kernels_[rank], kernels_[rank].log2_opacity - cut, grid, [&](uint32_t) { ++tiles; });
      pair_first_[rank + 1] = tiles;
    }
  });
  for (size_t rank = 0; rank < kernels_.size(); ++rank) pair_first_[rank + 1] += pair_first_[rank];
  const size_t pairs = pair_first_.back();
  pair_tiles_.resize(pairs);
  pair_kernels_.resize(pairs);
  parallel_for(kernels_.size(), kProjectBlock, [&](size_t begin, size_t end) {
    for (size_t rank = begin; rank < end; ++rank) {
      uint32_t pair = pair_first_[rank];
      for_each_tile(kernels_[rank], kernels_[rank].log2_opacity - cut, grid, [&](uint32_t tile) {
        pair_tiles_[pair] = tile;
        pair_kernels_[pair++] = static_cast<uint32_t>(rank);
      });
    }
  });
  // A stable counting sort by tile keeps the depth order.
  tile_first_.assign(grid.size() + 1, 0);
  for (uint32_t tile : pair_tiles_) ++tile_first_[tile + 1];
  for (size_t tile = 0; tile < grid.size(); ++tile) tile_first_[tile + 1] += tile_first_[tile];
  std::vector<uint32_t> next(tile_first_.begin(), tile_first_.end() - 1);
  tile_pairs_.resize(pairs);
  for (size_t pair = 0; pair < pairs; ++pair)
    tile_pairs_[next[pair_tiles_[pair]]++] = static_cast<uint32_t>(pair);
}

void TrainedView::blend() {
  const TileGrid grid = grid_of(camera_);
  picture_.resize(grid.width, grid.height);
  if (options_.depth) halfway_.assign(picture_.pixels(), ~0u);
  depth_sums_.resize(options_.spread ? picture_.pixels() : 0);
  spreads_.resize(depth_sums_.size());
  parallel_for(grid.size(), kTileBlock, [&](size_t begin, size_t end) {
    TilePixels tile;
    uint32_t halfway[kTilePixels];
    for (size_t t = begin; t < end; ++t) {
      const TilePlace place(grid, t);
      start_tile(place, tile);
      std::fill_n(halfway, kTilePixels, ~0u);
      uint32_t live = runs_of_tile(place.columns, place.rows);
      for (uint32_t i = tile_first_[t]; i < tile_first_[t + 1] && live != 0; ++i) {
        const uint32_t rank = pair_kernels_[tile_pairs_[i]];
        live &= ~blend_forward(kernels_[rank], place.frame(), options_.cuts, live, tile, options_.spread,
                               options_.depth ? halfway : nullptr, rank);
      }
      place.for_each_pixel([&](int i, size_t pixel) {
        const float through = std::abs(tile.transmittance[i]);
        picture_.red[pixel] = tile.red[i] + through * options_.background.x();
        picture_.green[pixel] = tile.green[i] + through * options_.background.y();
        picture_.blue[pixel] = tile.blue[i] + through * options_.background.z();
        picture_.alpha[pixel] = 1.0f - through;
        if (options_.depth) halfway_[pixel] = halfway[i];
        if (options_.spread) {
          depth_sums_[pixel] = tile.depth[i];
          spreads_[pixel] = tile.spread[i];
        }
      });
    }
  });
}

void TrainedView::find_depths(const KernelParameters& parameters) {
  const Projection projection(camera_);
  depths_.assign(picture_.pixels(), std::numeric_limits<float>::infinity());
  parallel_for(static_cast<size_t>(camera_.height), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < static_cast<size_t>(camera_.width); ++x) {
        const size_t pixel = y * static_cast<size_t>(camera_.width) + x;
        if (halfway_[pixel] == ~0u) continue;
        const size_t kernel = order_[halfway_[pixel]];
        const Eigen::Vector3d ray =
            projection.image_from_world.transpose() *
            Eigen::Vector3d((static_cast<double>(x) + 0.5 - camera_.centre_x_px) / camera_.focal_x_px,
                            (static_cast<double>(y) + 0.5 - camera_.centre_y_px) / camera_.focal_y_px, 1.0);
        const float* q = parameters.row(Family::Rotation, kernel);
        const Eigen::Quaterniond rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
        const Eigen::Vector3d scale =
            Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::LogScale, kernel))
                .cast<double>()
                .array()
                .exp();
        const Eigen::Vector3d offset =
            Eigen::Map<const Eigen::Vector3f>(parameters.row(Family::Position, kernel)).cast<double>() -
            projection.position_m;
        const Eigen::Vector3d along = (rotation.conjugate() * ray).cwiseQuotient(scale);
        const Eigen::Vector3d centre = (rotation.conjugate() * offset).cwiseQuotient(scale);
        depths_[pixel] = static_cast<float>(along.dot(centre) / along.squaredNorm());
      }
    }
  });
}

TrainedView::TrainedView() = default;
TrainedView::~TrainedView() = default;
TrainedView::TrainedView(TrainedView&&) noexcept = default;
TrainedView& TrainedView::operator=(TrainedView&&) noexcept = default;

void TrainedView::use_device(std::unique_ptr<Backend> backend) {
  device_ = std::make_unique<DeviceBlender>(std::move(backend));
}

void TrainedView::draw(const KernelParameters& parameters, const Camera& camera,
                       const TrainedViewOptions& options) {
  camera_ = camera;
  options_ = options;
  project(parameters);
  if (!blend_on_device()) {
    bin();
    blend();
  }
  if (options.depth) find_depths(parameters);
}

// False if there is no device, or it failed and is no longer used.
bool TrainedView::blend_on_device() {
  if (!device_) return false;
  if (auto done = device_->forward(kernels_, camera_.width, camera_.height, options_.cuts); !done) {
    log_warn("training: the device failed (%s); the CPU continues", done.error().message.c_str());
    device_.reset();
    return false;
  }
  picture_.resize(camera_.width, camera_.height);
  halfway_.resize(options_.depth ? picture_.pixels() : 0);
  depth_sums_.resize(options_.spread ? picture_.pixels() : 0);
  spreads_.resize(depth_sums_.size());
  const std::span<const TrainPixel> pixels = device_->pixels();
  parallel_for(pixels.size(), kPixelBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const TrainPixel& pixel = pixels[i];
      picture_.red[i] = pixel.red + pixel.through * options_.background.x();
      picture_.green[i] = pixel.green + pixel.through * options_.background.y();
      picture_.blue[i] = pixel.blue + pixel.through * options_.background.z();
      picture_.alpha[i] = 1.0f - pixel.through;
      if (options_.depth) halfway_[i] = pixel.halfway;
      if (options_.spread) {
        depth_sums_[i] = pixel.depth_sum;
        spreads_[i] = pixel.spread;
      }
    }
  });
  return true;
}

bool TrainedView::backward_on_device(const PicturePlanes& by_picture, std::span<const float> by_spread) {
  if (!device_) return false;
  device_by_picture_.resize(by_picture.pixels());
  parallel_for(by_picture.pixels(), kPixelBlock, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      device_by_picture_[i] = {by_picture.red[i], by_picture.green[i], by_picture.blue[i],
                               by_picture.alpha[i], by_spread.empty() ? 0.0f : by_spread[i]};
  });
  if (auto done = device_->backward(device_by_picture_, options_.background, kernel_gradients_); !done) {
    log_warn("training: the device failed (%s); the CPU continues", done.error().message.c_str());
    device_.reset();
    bin();
    blend();
    return false;
  }
  return true;
}

// The gradients by the kernels, in kernel_gradients_.
void TrainedView::blend_back(const PicturePlanes& by_picture, std::span<const float> by_spread) {
  const TileGrid grid = grid_of(camera_);
  pair_gradients_.resize(pair_kernels_.size());
  parallel_for(grid.size(), kTileBlock, [&](size_t begin, size_t end) {
    TilePixels tile;
    TileGradient by;
    for (size_t t = begin; t < end; ++t) {
      const TilePlace place(grid, t);
      start_tile(place, tile);
      std::fill_n(reinterpret_cast<float*>(&by), sizeof(by) / sizeof(float), 0.0f);
      place.for_each_pixel([&](int i, size_t pixel) {
        by.red[i] = by_picture.red[pixel];
        by.green[i] = by_picture.green[pixel];
        by.blue[i] = by_picture.blue[pixel];
        by.alpha[i] = by_picture.alpha[pixel];
        by.left[i] = by.red[i] * picture_.red[pixel] + by.green[i] * picture_.green[pixel] +
                     by.blue[i] * picture_.blue[pixel] + by.alpha[i] * picture_.alpha[pixel];
        if (!by_spread.empty()) {
          by.spread[i] = by_spread[pixel];
          by.final_alpha[i] = picture_.alpha[pixel];
          by.final_depth[i] = depth_sums_[pixel];
          by.left[i] += 2 * by_spread[pixel] * spreads_[pixel];  // the spread is quadratic in the weights
        }
      });
      uint32_t live = runs_of_tile(place.columns, place.rows);
      uint32_t i = tile_first_[t];
      for (; i < tile_first_[t + 1] && live != 0; ++i) {
        const uint32_t pair = tile_pairs_[i];
        live &= ~blend_backward(kernels_[pair_kernels_[pair]], place.frame(), options_.cuts, live, tile, by,
                                !by_spread.empty(), pair_gradients_[pair]);
      }
      for (; i < tile_first_[t + 1]; ++i) pair_gradients_[tile_pairs_[i]] = {};
    }
  });
  kernel_gradients_.resize(kernels_.size());
  parallel_for(kernels_.size(), kProjectBlock, [&](size_t begin, size_t end) {
    for (size_t rank = begin; rank < end; ++rank) {
      EllipseGradient& total = kernel_gradients_[rank] = {};
      for (uint32_t pair = pair_first_[rank]; pair < pair_first_[rank + 1]; ++pair) {
        const EllipseGradient& part = pair_gradients_[pair];
        total.sum += part.sum;
        total.x += part.x;
        total.y += part.y;
        total.xx += part.xx;
        total.xy += part.xy;
        total.yy += part.yy;
        total.red += part.red;
        total.green += part.green;
        total.blue += part.blue;
        total.depth += part.depth;
      }
    }
  });
}

CameraGradient TrainedView::backward(const KernelParameters& parameters, const PicturePlanes& by_picture,
                                     KernelParameters& gradient, std::span<const float> by_spread) {
  if (!backward_on_device(by_picture, by_spread)) blend_back(by_picture, by_spread);
  gradient.resize(parameters.size());
  gradient.clear_to_zero();
  const Projection projection(camera_);
  camera_gradients_.resize(kernels_.size());
  parallel_for(kernels_.size(), kProjectBlock / 2, [&](size_t begin, size_t end) {
    for (size_t rank = begin; rank < end; ++rank) {
      camera_gradients_[rank] = project_backward(projection, parameters, order_[rank], options_.sh_degree,
                                                 kernel_gradients_[rank], gradient);
    }
  });
  CameraGradient camera;
  for (const CameraGradient& one : camera_gradients_) {
    camera.position += one.position;
    camera.turn += one.turn;
  }
  return camera;
}

}  // namespace livegs
