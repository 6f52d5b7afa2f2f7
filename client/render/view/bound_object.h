// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "skin/kernels/kernel_reach.h"
#include "skin/rest_body.h"
#include "skin/skin_kernels.h"

namespace livegs {

// An object as of one revision, its kernels tied to their drivers.
struct BoundObject {
  std::shared_ptr<const GaussianAsset> asset;
  RestBody rest;
  KernelBindings bindings;
  KernelReach reach;
  bool environment = false;
};

// What takes long of SceneView::add and change, about 0.1 s for 300k kernels, apart: on any thread.
Result<BoundObject> bind_object(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                                bool environment);

}  // namespace livegs
