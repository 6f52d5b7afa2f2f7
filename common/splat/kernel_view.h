// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/image.h"

// Views of one asset that name the kernels behind each pixel, for segmentation and for rays of users. The
// projection and the thresholds are those of rasterise.h.

namespace livegs {

inline constexpr uint32_t kNoKernel = ~0u;

struct KernelView {
  int width = 0, height = 0;
  // The kernel in which transmittance falls under a half; kNoKernel if it never does.
  std::vector<uint32_t> kernel;
  // Depth along the view axis at which the ray meets the greatest response of that kernel, metres; infinity
  // without a kernel. Unlike the centre of the kernel, this point is on the surface that wide kernels form.
  std::vector<float> depth_m;
  // Colour of all kernels over black; alpha is coverage.
  Image image;
};

// Depth along the view axis of the greatest response of a kernel on a ray. `mean_m` and `covariance_m2` are
// in the image frame of the camera (x right, y down, z forward); `ray` has z = 1. `floor_m` is added to each
// axis as a convolution, so that a flat kernel has an inverse:
//   t = rayᵀ Σ⁻¹ mean / rayᵀ Σ⁻¹ ray.
double greatest_response_depth_m(const Eigen::Vector3d& mean_m, const Eigen::Matrix3d& covariance_m2,
                                 const Eigen::Vector3d& ray, double floor_m);

// Sum of alpha times transmittance of one kernel over the pixels with one label, px.
struct LabelWeight {
  uint32_t kernel;
  uint32_t label;
  float weight;
};

// Deterministic for any thread count. Buffers are kept between calls; not shared between threads.
class KernelRasteriser {
 public:
  KernelRasteriser();
  ~KernelRasteriser();
  KernelRasteriser(KernelRasteriser&&) noexcept;
  KernelRasteriser& operator=(KernelRasteriser&&) noexcept;

  void draw(const DrawnObject& object, const Camera& camera, KernelView& view);

  // Appends the weights of all kernels that are seen, tile by tile; a kernel occurs once per tile and label.
  // `labels` has one entry per pixel, rows from the top.
  void weigh(const DrawnObject& object, const Camera& camera, std::span<const uint16_t> labels,
             std::vector<LabelWeight>& weights);

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace livegs
