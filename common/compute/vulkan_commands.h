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
  // next submit, read or destroy_buffer of the backend, which wait for it, or when an upload finds no more
  // room.
  virtual Result<VkCommandBuffer> record() = 0;

  // Since the backend was made.
  struct Traffic {
    uint64_t uploaded_bytes = 0, submissions = 0;
  };
  virtual const Traffic& traffic() const = 0;

  // Null if unknown. Storage, indirect and transfer are what it may be used for.
  virtual VkBuffer buffer_of(BufferId buffer) const = 0;
};

// What `backend` is underneath; null for one that is not create_vulkan_backend's.
VulkanCommands* vulkan_commands(Backend& backend);

}  // namespace livegs
