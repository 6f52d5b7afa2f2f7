// SPDX-License-Identifier: Apache-2.0
#include "render/view/bound_object.h"

#include <string>

namespace livegs {

Result<BoundObject> bind_object(uint32_t object_id, std::shared_ptr<const GaussianAsset> asset, RestBody rest,
                                bool environment) {
  auto bindings = bind_kernels(*asset, rest);
  if (!bindings)
    return Error{bindings.error().code,
                 "object " + std::to_string(object_id) + ": " + bindings.error().message};
  KernelReach reach = kernel_reach(rest, *bindings);
  ShapeSample shape;
  if (!environment) shape = ShapeSample(*asset, *bindings);
  return BoundObject{std::move(asset), std::move(rest),  *std::move(bindings),
                     std::move(reach), std::move(shape), environment};
}

}  // namespace livegs
