// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"
#include "compute/vulkan_handles.h"

namespace livegs {

// How client/render draws what passes have computed: into the same command buffer, from the same buffers. As
// Backend, one thread at a time.
class VulkanCommands {
 public:
  virtual ~VulkanCommands() = default;

  // The command buffer that dispatches are recorded into, after a barrier on everything in it. It runs at the
  // next submit, upload, read or destroy_buffer of the backend, which wait for it.
  virtual Result<VkCommandBuffer> record() = 0;

  // Null if unknown. Storage, indirect and transfer are what it may be used for.
  virtual VkBuffer buffer_of(BufferId buffer) const = 0;
};

// What `backend` is underneath; null for one that is not create_vulkan_backend's.
VulkanCommands* vulkan_commands(Backend& backend);

}  // namespace livegs
