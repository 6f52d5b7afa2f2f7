// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <span>

#include "splat/raster/frame_splats.h"
#include "splat/rasterise.h"
#include "splat/tiles/frame_tiles.h"

namespace livegs {

// Draws images of objects on a device by tiles, or on the CPU (Rasteriser) without one. Both give the same
// image to rounding, 32-bit floats. If the device fails, a warning is logged and the CPU continues. It also
// draws single images that the device cannot hold. Assets that are drawn again stay on the device. One thread
// at a time.
class ImageRasteriser {
 public:
  explicit ImageRasteriser(std::unique_ptr<Backend> device = nullptr);
  ~ImageRasteriser();
  ImageRasteriser(const ImageRasteriser&) = delete;
  ImageRasteriser& operator=(const ImageRasteriser&) = delete;

  // As Rasteriser::draw with image_only. Objects have different ids; options.distance_from_m is not used.
  void draw(std::span<const DrawnObject> objects, const Camera& camera, const RasteriseOptions& options,
            Image& image);
  bool on_device() const { return device_ != nullptr; }
  // Kernels in the last image that may be visible.
  size_t visible_kernels() const { return visible_kernels_; }

 private:
  struct Device;
  Result<void> draw_on_device(std::span<const DrawnObject> objects, const Camera& camera,
                              const RasteriseOptions& options, Image& image);

  std::unique_ptr<Device> device_;
  Rasteriser rasteriser_;
  RasterisedView view_;
  size_t visible_kernels_ = 0;
};

}  // namespace livegs
