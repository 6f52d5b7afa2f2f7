// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "compute/backend.h"
#include "compute/device_image.h"
#include "render/blend_precision.h"
#include "splat/image.h"
#include "splat/raster/frame_splats.h"

namespace livegs {

struct VulkanHandles;

// Draws a sorted frame for one eye or two: one indirect draw of instanced quads, nearest first, blended in
// the colour space the kernels were trained in, both eyes by multiview (which is tried out first: drivers get
// it wrong); then one resolve that puts the background behind them, decodes and writes sRGB.
class SplatPass {
 public:
  struct Options {
    BlendPrecision precision = BlendPrecision::Auto;
  };
  // `backend` is a Vulkan one of a device that can draw, and outlives the painter.
  static Result<std::unique_ptr<SplatPass>> create(Backend& backend, const VulkanHandles& handles,
                                                   const Options& options);
  virtual ~SplatPass() = default;

  // Records the draw. All eyes have the images' size.
  virtual Result<void> paint(const FrameSplats& frame, int width, int height, int eyes) = 0;
  virtual int eyes_a_draw() const = 0;  // of what was painted: all of them, or 1 where multiview draws wrong
  // Records the resolve of what was painted.
  virtual Result<void> resolve(const Eigen::Vector3f& background) = 0;
  // Runs all that is recorded and reads an image an eye. Display-encoded, alpha is coverage, 8 bits a
  // channel.
  virtual Result<void> read(std::vector<Image>& images) = 0;
  // Runs all that is recorded and a copy of each eye into a layer of `image`, which is on the same device.
  virtual Result<void> copy_into(const DeviceImage& image) = 0;
  // What went into the resolve, after it: premultiplied colour as it was blended, and coverage.
  virtual Result<void> read_blended(std::vector<Image>& images) = 0;
};

}  // namespace livegs
