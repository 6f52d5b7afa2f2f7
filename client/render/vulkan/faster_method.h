// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "compute/vulkan_device.h"
#include "core/result.h"
#include "render/splat_renderer.h"

namespace livegs {

// Quads or Tiles: the method with less device time for a test picture of 100 000 kernels, which it draws a
// few times with each. Devices differ by their share of hardware for vertices and fragments. Without
// measuring: Tiles on software devices and on those that cannot draw; Quads without a clock. If one method
// fails, the other; if both fail, the error, or Quads without memory for the test picture.
Result<DrawMethod> faster_method(const std::shared_ptr<VulkanDevice>& device);

}  // namespace livegs
