// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "skin/kernels/kernel_reach.h"
#include "skin/rest_body.h"
#include "skin/shape_sample.h"
#include "skin/skin_kernels.h"

namespace livegs {

// One revision of an object, with its kernels bound to their drivers.
struct BoundObject {
  std::shared_ptr<const GaussianAsset> asset;
  RestBody rest;
  KernelBindings bindings;
  KernelReach reach;
  ShapeSample shape;  // casts the shadow; empty: none, as for an environment
  bool environment = false;
};

// The expensive part of SceneView::add and change, about 0.1 s for 300k kernels. Any thread.
Result<BoundObject> bind_object(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                                bool environment);

}  // namespace livegs
