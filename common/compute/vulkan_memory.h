// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "compute/vulkan_handles.h"

namespace livegs {

// Allocates device memory in a few large blocks, because a driver may permit only 4096 allocations and each
// is a system call. First fit within a block; free neighbours merge. One empty block of the usual size is
// kept until memory for another block is exhausted.
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

  // Allocates device-local memory for `needs`. TooLarge if the device or its limit has no more.
  Result<Range> allocate(const VkMemoryRequirements& needs);
  void free(const Range& range);
  VkDeviceMemory memory_of(const Range& range) const { return blocks_[range.block].memory; }

 private:
  struct Block {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint32_t type = 0;
    VkDeviceSize bytes = 0;                     // 0 after release
    std::map<VkDeviceSize, VkDeviceSize> free;  // offset to bytes; ranges never touch
  };

  Result<void> add_block(uint32_t type, VkDeviceSize bytes);
  static bool empty(const Block& block);
  void give_back_empty(size_t usual_kept);  // keeps this many of the usual size
  void give_back(Block& block);

  const VulkanHandles& handles_;
  std::vector<Block> blocks_;
};

// A buffer in host-visible memory for copies to and from the device: mapped, coherent, and cached if
// available. It has its own allocation.
class HostBuffer {
 public:
  HostBuffer() = default;
  ~HostBuffer();
  HostBuffer(const HostBuffer&) = delete;
  HostBuffer& operator=(const HostBuffer&) = delete;

  // Call once. `usage`: VK_BUFFER_USAGE_TRANSFER_SRC_BIT, DST_BIT or both.
  Result<void> create(const VulkanHandles& handles, VkDeviceSize bytes, VkBufferUsageFlags usage);
  VkBuffer buffer() const { return buffer_; }
  std::byte* bytes() const { return bytes_; }

 private:
  const VulkanHandles* handles_ = nullptr;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  VkDeviceMemory memory_ = VK_NULL_HANDLE;
  std::byte* bytes_ = nullptr;
};

}  // namespace livegs
