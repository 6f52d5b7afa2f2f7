// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gaussian/gaussian_asset.h"
#include "splat/camera.h"
#include "splat/image.h"

// Scores of a room from which a thing was taken, against the room made without it (sample/made_room.h).

namespace livegs {

struct FillScores {
  size_t hole_pixels = 0;   // of all views
  double psnr_db = 0;       // in the hole: where the twin shows kernels that the whole room does not have
  double rim_psnr_db = 0;   // within a few pixels outside it
  double depth_p95_mm = 0;  // absolute difference of depth along the view axis in the hole; 95th percentile
  double open_share = 0;    // of the hole's pixels: no surface is there
};

// `before`: with the thing. `twin`: made without it. `after`: from which it was taken.
FillScores score_fill(const GaussianAsset& before, const GaussianAsset& twin, const GaussianAsset& after,
                      std::span<const Camera> cameras);

// Twin above, the taken room below; pixels of the hole are framed by white ones.
Image fill_picture(const GaussianAsset& before, const GaussianAsset& twin, const GaussianAsset& after,
                   const Camera& camera);

}  // namespace livegs
