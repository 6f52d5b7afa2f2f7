// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/image.h"

// The CPU tile rasteriser: the oracle that every GPU path is compared with, and the renderer of machines without a
// GPU. Kerbl et al. 2023 and Zwicker et al. 2001 (EWA splatting); cut-offs as in the reference implementation:
// low-pass 0.3 px², opacity below 1/255 skipped, stop when transmittance would fall under 1e-4.

namespace livegs {

enum class DepthOrder {
  ViewZ,     // along the view axis: parity with the reference implementation
  Distance,  // from the camera: does not change when the head turns (KHR_gaussian_splatting's default)
};

struct RasteriseOptions {
  Eigen::Vector3f background{0, 0, 0};
  DepthOrder order = DepthOrder::ViewZ;
  int max_sh_degree = 3;
  float min_contribution_px = 0;  // as eye_view (project_splats.h) has it
  float max_radius_px = 0;        // as well; 0: none
  std::optional<Eigen::Vector3d> distance_from_m = {};  // in Distance order, of a point between two eyes; none: from the camera
};

struct RasterisedView {
  Image image;                      // colour over the background; alpha is coverage
  std::vector<float> depth_m;       // along the view axis where transmittance first falls under 0.5; infinity where it never does
  std::vector<uint32_t> object_id;  // of the object with the largest share of the pixel's opacity; kNoObject where coverage < 0.5
};
inline constexpr uint32_t kNoObject = ~0u;

// Draws all objects in one sorted set. Deterministic for any thread count. Buffers are kept between calls, so one
// Rasteriser serves one stream of frames; it is not shared between threads.
class Rasteriser {
 public:
  Rasteriser();
  ~Rasteriser();
  Rasteriser(Rasteriser&&) noexcept;
  Rasteriser& operator=(Rasteriser&&) noexcept;

  void draw(std::span<const DrawnObject> objects, const Camera& camera, const RasteriseOptions& options,
            RasterisedView& view);

  struct Times {
    double project_ms = 0, sort_ms = 0, blend_ms = 0;
    size_t visible_kernels = 0;
  };
  const Times& last_times() const;

 private:
  struct Buffers;
  std::unique_ptr<Buffers> buffers_;
};

}  // namespace livegs
