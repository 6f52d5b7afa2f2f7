// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <vector>

#include "analysis/run/analysis_target.h"
#include "gaussian/posed_kernels.h"

namespace livegs {

// Longest side of a view, in pixels.
inline constexpr int kViewLongSide_px = 768;

// Kernels of a scene at one instant.
struct ViewedScene {
  struct Object {
    uint32_t object_id = 0;
    std::shared_ptr<const GaussianAsset> asset;
    PosedKernels kernels;
  };
  std::vector<Object> objects;
};

// Draws up to `count` views of an object, best first, as PNG. Each view has the scene with the object
// outlined and the object alone on white, for a model, and the mask, for the user. Deterministic; any thread.
// A stop request takes effect after the current view.
Result<std::vector<TargetView>> target_views(const ViewedScene& scene, uint32_t object_id, int count,
                                             std::stop_token stop);

// The pictures of a view in the colours of the parts, as PNG; empty if the view has no sights or the object
// was not captured.
Result<std::vector<AnalysisImage>> part_pictures(const TargetView& view, const ObjectFacts& facts,
                                                 const v1::PhysicalParameters& physics);

}  // namespace livegs
