// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "analysis/run/analysis_target.h"
#include "gaussian/posed_kernels.h"

namespace livegs {

// Longest side of the pictures, in pixels.
inline constexpr int kViewLongSide_px = 768;

// Kernels of a scene at one moment.
struct ViewedScene {
  struct Object {
    uint32_t object_id = 0;
    std::shared_ptr<const GaussianAsset> asset;
    PosedKernels kernels;
  };
  std::vector<Object> objects;
};

// `count` looks at an object, best first, as PNG: the scene with the object outlined, and the object alone
// over white, both for a model; and the mask, for a person. Deterministic; any thread. A requested stop ends
// it after the picture that is being drawn.
Result<std::vector<TargetView>> target_views(const ViewedScene& scene, uint32_t object_id, int count,
                                             std::stop_token stop);

}  // namespace livegs
