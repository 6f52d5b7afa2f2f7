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

// Draws a sorted frame for one or two eyes, blended nearest first in the colour space of training.
class SplatPass {
 public:
  // `backend`: a Vulkan backend; must outlive the pass.
  //
  // One indirect draw of instanced quads. Both eyes use multiview, after a check, since some drivers get it
  // wrong. One resolve pass adds the background, decodes and writes sRGB. Unavailable if the device cannot
  // draw.
  static Result<std::unique_ptr<SplatPass>> create_quads(Backend& backend, const VulkanHandles& handles,
                                                         BlendPrecision precision);
  // Compute passes (splat/tiles). `blended`: for read_blended() instead of read() and copy_into().
  static std::unique_ptr<SplatPass> create_tiles(Backend& backend, const VulkanHandles& handles,
                                                 bool blended);
  virtual ~SplatPass() = default;

  // Records the draw. All eyes have this size. `frame` is used until the picture has been read or copied.
  virtual Result<void> paint(const FrameSplats& frame, int width, int height, int eyes) = 0;
  virtual int eyes_a_draw() const = 0;  // of the last paint: all eyes, or 1 if multiview is unusable
  // Records the resolve of the painted eyes.
  virtual Result<void> resolve(const Eigen::Vector3f& background) = 0;
  // Runs all recorded commands and reads one image per eye. Display-encoded, alpha is coverage, 8 bits per
  // channel.
  virtual Result<void> read(std::vector<Image>& images) = 0;
  // Runs all recorded commands and copies each eye into a layer of `image`, which is on the same device.
  virtual Result<void> copy_into(const DeviceImage& image) = 0;
  // The input of the resolve, after it: premultiplied blended colour, and coverage.
  virtual Result<void> read_blended(std::vector<Image>& images) = 0;
};

}  // namespace livegs
