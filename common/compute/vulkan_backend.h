// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "compute/backend.h"
#include "compute/vulkan_device.h"

namespace livegs {

// Runs the shaders. Buffers lie in device memory and are reached through one staging buffer; dispatches are
// recorded into one command buffer, each after a barrier on the one before, and run at submit, upload, read
// or destroy_buffer. The pipeline of a pass is made at its first dispatch and kept.
Result<std::unique_ptr<Backend>> create_vulkan_backend(std::shared_ptr<VulkanDevice> device);

}  // namespace livegs
