// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/backend.h"
#include "compute/vulkan_handles.h"

namespace livegs {

// Lets client/render draw the results of passes, in the same command buffer and from the same buffers. One
// thread at a time, as for Backend.
class VulkanCommands {
 public:
  virtual ~VulkanCommands() = default;

  // The command buffer that records dispatches, after a barrier on its previous commands. It runs at the next
  // submit, read or destroy_buffer of the backend, which wait for it, or when an upload does not fit.
  virtual Result<VkCommandBuffer> record() = 0;

  // Totals since the backend was created.
  struct Traffic {
    uint64_t uploaded_bytes = 0, submissions = 0, dispatches = 0;
    uint64_t barriers = 0;  // of memory; layout changes of images are not counted
  };
  virtual const Traffic& traffic() const = 0;

  // Null if unknown. Usage flags: storage, indirect and transfer.
  virtual VkBuffer buffer_of(BufferId buffer) const = 0;
};

// The Vulkan interface of `backend`; null if create_vulkan_backend did not create it.
VulkanCommands* vulkan_commands(Backend& backend);

}  // namespace livegs
