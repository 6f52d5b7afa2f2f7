// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <vector>

#include "compute/vulkan_handles.h"

namespace livegs {

// Device memory in a few large blocks, since a driver may grant as few as 4096 allocations and each costs it
// a system call. First fit within a block; neighbours that are free merge. Of
// blocks with nothing in them one of the usual size is kept, until there is no memory for another.
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

  // Device-local memory for `needs`. TooLarge when the device, or its limit, has no more.
  Result<Range> allocate(const VkMemoryRequirements& needs);
  void free(const Range& range);
  VkDeviceMemory memory_of(const Range& range) const { return blocks_[range.block].memory; }

 private:
  struct Block {
    VkDeviceMemory memory = VK_NULL_HANDLE;
    uint32_t type = 0;
    VkDeviceSize bytes = 0;                     // 0 when it was given back
    std::map<VkDeviceSize, VkDeviceSize> free;  // offset to bytes; no two touch
  };

  Result<void> add_block(uint32_t type, VkDeviceSize bytes);
  static bool empty(const Block& block);
  void give_back_empty(size_t usual_kept);  // but so many of the usual size
  void give_back(Block& block);

  const VulkanHandles& handles_;
  std::vector<Block> blocks_;
};

// A buffer in memory that the host sees, mapped, coherent, and cached where there is such: for copies to and
// from the device. It has an allocation of its own.
class HostBuffer {
 public:
  HostBuffer() = default;
  ~HostBuffer();
  HostBuffer(const HostBuffer&) = delete;
  HostBuffer& operator=(const HostBuffer&) = delete;

  // Once. `usage`: VK_BUFFER_USAGE_TRANSFER_SRC_BIT, DST_BIT or both.
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
