// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "compute/vulkan_handles.h"

namespace livegs {

// Device memory in a few large blocks, since a driver may grant as few as 4096 allocations and each costs it
// a system call. First fit within a block; neighbours that are free merge. Blocks are kept until the end.
class VulkanMemory {
 public:
  struct Range {
    uint32_t block = 0;
    VkDeviceSize offset = 0;
    VkDeviceSize bytes = 0;
  };

  explicit VulkanMemory(const VulkanHandles& handles) : handles_(handles) {}
  ~VulkanMemory();
  VulkanMemory(const VulkanMemory&) = delete;
  VulkanMemory& operator=(const VulkanMemory&) = delete;

  // Device-local memory for `needs`.
  Result<Range> allocate(const VkMemoryRequirements& needs);
  void free(const Range& range);
  VkDeviceMemory memory_of(const Range& range) const { return blocks_[range.block].memory; }

 private:
  struct Block {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint32_t type = 0;
    std::map<VkDeviceSize, VkDeviceSize> free;  // offset to bytes; no two touch
  };

  const VulkanHandles& handles_;
  std::vector<Block> blocks_;
};

// The first memory type among `allowed` bits with all of `wanted`; false if there is none.
bool find_memory_type(const VulkanHandles& handles, uint32_t allowed, VkMemoryPropertyFlags wanted,
                      uint32_t& type);

}  // namespace livegs
