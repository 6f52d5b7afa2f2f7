// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "compute/backend.h"
#include "splat/camera.h"
#include "train/kernel_parameters.h"
#include "train/render/project_trained.h"
#include "train/render/render_cuts.h"
#include "train/render/train_blend_layout.h"

namespace livegs {

class DeviceBlender;

// A picture as planes of width * height floats, rows from the top.
struct PicturePlanes {
  int width = 0, height = 0;
  std::vector<float> red, green, blue;
  std::vector<float> alpha;

  void resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    const size_t count = static_cast<size_t>(width) * static_cast<size_t>(height);
    for (auto* plane : {&red, &green, &blue, &alpha}) plane->resize(count);
  }
  size_t pixels() const { return red.size(); }
};

struct TrainedViewOptions {
  Eigen::Vector3f background{0, 0, 0};
  int sh_degree = 3;
  RenderCuts cuts;
  bool depth = false;   // fills depths()
  bool spread = false;  // fills spreads() and their data for backward
};

// Draws trained kernels and takes the derivative of a loss back to their numbers. Both passes run front to
// back over tiles of 16 x 16 pixels (Kerbl et al. 2023, algorithm 2). Results have the same bits for any
// number of threads: each (kernel, tile) pair has its own row of sums, and the rows of a kernel are added in
// order. Buffers are kept between calls. Not shared between threads.
class TrainedView {
 public:
  TrainedView();
  ~TrainedView();
  TrainedView(TrainedView&&) noexcept;
  TrainedView& operator=(TrainedView&&) noexcept;

  // Binning and blending, forward and back, run as passes on this device from now on (device_blender.h). If
  // it fails, a warning is logged and the CPU continues.
  void use_device(std::unique_ptr<Backend> backend);

  // Colours over the background, without an upper limit; alpha is coverage.
  void draw(const KernelParameters& parameters, const Camera& camera, const TrainedViewOptions& options);
  const PicturePlanes& picture() const { return picture_; }

  // Depth along the view axis where the response of the kernel is greatest on the pixel's ray, for the kernel
  // at which transmittance falls under 0.5; infinity if it never does. Scene units.
  const std::vector<float>& depths() const { return depths_; }

  // By pixel: the spread of depths along the ray (blend_tile.h), scene units.
  std::span<const float> spreads() const { return spreads_; }

  // Kernels of the last draw, by depth.
  size_t visible_count() const { return order_.size(); }
  // For each kernel of the last draw: 1 if it was visible.
  std::span<const uint8_t> visible() const { return visible_; }

  // `by_picture`: dL by the colour (over the background) and alpha of each pixel. Writes the derivative by
  // every trained number; 0 for kernels that were not visible. `by_spread`: dL by the spread of each pixel,
  // or empty; needs TrainedViewOptions::spread. Returns the derivative by the pose of the camera. Call after
  // draw, with the same parameters.
  CameraGradient backward(const KernelParameters& parameters, const PicturePlanes& by_picture,
                          KernelParameters& gradient, std::span<const float> by_spread = {});

 private:
  bool blend_on_device();
  bool backward_on_device(const PicturePlanes& by_picture, std::span<const float> by_spread);
  void blend_back(const PicturePlanes& by_picture, std::span<const float> by_spread);
  void project(const KernelParameters& parameters);
  void bin();
  void blend();
  void find_depths(const KernelParameters& parameters);

  Camera camera_;
  TrainedViewOptions options_;
  PicturePlanes picture_;
  std::vector<float> depths_;
  std::vector<float> depth_sums_, spreads_;  // by pixel
  std::vector<uint32_t> halfway_;            // rank of the kernel at which a pixel becomes half opaque
  std::vector<ProjectedKernel> projected_;   // by kernel
  std::vector<uint8_t> visible_;             // by kernel
  std::vector<ProjectedKernel> kernels_;     // visible ones, nearest first
  std::vector<uint32_t> order_;              // kernel index of each
  std::vector<uint32_t> pair_first_;         // by rank: its first pair; one more at the end
  std::vector<uint32_t> pair_tiles_;         // by pair
  std::vector<uint32_t> pair_kernels_;       // by pair: rank
  std::vector<uint32_t> tile_first_;         // by tile: its first entry in tile_pairs_; one more at the end
  std::vector<uint32_t> tile_pairs_;         // pairs of each tile, nearest first
  std::vector<EllipseGradient> pair_gradients_;
  std::vector<uint64_t> keys_;
  std::unique_ptr<DeviceBlender> device_;
  std::vector<TrainPixelGradient> device_by_picture_;
  std::vector<EllipseGradient> kernel_gradients_;  // by rank
  std::vector<CameraGradient> camera_gradients_;   // by rank
};

}  // namespace livegs
