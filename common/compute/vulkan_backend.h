// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "compute/backend.h"
#include "compute/vulkan_device.h"

namespace livegs {

// Runs the shaders. Buffers lie in device memory and are reached through one staging buffer of 8 MiB. Uploads
// and dispatches are recorded into one command buffer, each after a barrier on the one before, and run at
// submit, read or destroy_buffer, or when the staging buffer is full: a frame whose drivers fit into it is
// one submission. The pipeline of a pass is made at its first dispatch and kept.
Result<std::unique_ptr<Backend>> create_vulkan_backend(std::shared_ptr<VulkanDevice> device);

}  // namespace livegs
