// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "compute/backend.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/project/projected_kernel.h"
#include "splat/tiles/tile_pairs.h"
#include "train/render/project_trained.h"
#include "train/render/render_cuts.h"
#include "train/render/train_blend_layout.h"

namespace livegs {

// Blends projected kernels and takes a gradient by the picture back to them, by passes of a backend. The
// results have the same bits in every run on one device, and agree with render/blend_tile.h to rounding. Data
// are copied to the device and back twice per picture. One thread.
class DeviceBlender {
 public:
  explicit DeviceBlender(std::unique_ptr<Backend> backend);

  // `kernels`: nearest first. pixels() then holds the picture, row by row.
  Result<void> forward(std::span<const ProjectedKernel> kernels, int width, int height,
                       const RenderCuts& cuts);
  std::span<const TrainPixel> pixels() const { return std::span(picture_).subspan(1); }

  // The gradient by the colours over `background`, the alphas and the spreads of the last forward();
  // by_kernel receives a row for each kernel.
  Result<void> backward(std::span<const TrainPixelGradient> by_picture, const Eigen::Vector3f& background,
                        std::vector<EllipseGradient>& by_kernel);

 private:
  Result<void> make_room();
  Result<void> upload_kernels(std::span<const ProjectedKernel> kernels);

  std::unique_ptr<Backend> backend_;  // outlives the buffers
  TilePairs pairs_;
  Buffer rows_, depths_, order_, drawn_, picture_buffer_, by_picture_, pair_gradients_, kernel_firsts_,
      kernel_gradients_;
  uint32_t count_ = 0, order_count_ = 0;
  int width_ = 0, height_ = 0;
  RenderCuts cuts_;
  std::vector<TrainPixel> picture_;  // after a header
  std::vector<SplatRow> row_memory_;
  std::vector<float> depth_memory_;
};

}  // namespace livegs
