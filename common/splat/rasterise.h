// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>

#include "gaussian/posed_kernels.h"
#include "splat/camera.h"
#include "splat/project/raster_options.h"

// The CPU tile rasteriser: the reference for every GPU path, and the renderer on machines without a GPU.
// Kerbl et al. 2023 and Zwicker et al. 2001 (EWA splatting). Thresholds as in the reference implementation:
// low-pass 0.3 px², opacity below 1/255 skipped, stop before transmittance falls under 1e-4.

namespace livegs {

// Draws all objects in one sorted set. Deterministic for any thread count. Buffers are kept between calls, so
// one Rasteriser serves one sequence of frames. Not shared between threads.
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
