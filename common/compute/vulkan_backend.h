// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "compute/backend.h"
#include "compute/vulkan_device.h"

namespace livegs {

// Runs the shaders. Buffers are in device memory and are accessed through one staging buffer of 8 MiB.
// Uploads and dispatches are recorded into one command buffer, each after a barrier. They run at submit, read
// or destroy_buffer, or when the staging buffer is full. If the drivers of a frame fit the staging buffer,
// the frame is one submission. The pipeline of a pass is created at its first dispatch and kept.
Result<std::unique_ptr<Backend>> create_vulkan_backend(std::shared_ptr<VulkanDevice> device);

}  // namespace livegs
