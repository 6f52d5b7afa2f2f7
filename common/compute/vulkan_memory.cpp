// SPDX-License-Identifier: Apache-2.0
#include "compute/vulkan_memory.h"

#include <algorithm>

namespace livegs {

namespace {

// Block size. A scene of a million kernels takes some tens of blocks at most, and blocks fit lavapipe's 2 GiB
// heap. A larger buffer gets its own block.
constexpr VkDeviceSize kBlockBytes = VkDeviceSize{32} << 20;

VkDeviceSize round_up(VkDeviceSize value, VkDeviceSize alignment) {
  return (value + alignment - 1) / alignment * alignment;
}

// Allocates from the first free range that is large enough.
bool take(std::map<VkDeviceSize, VkDeviceSize>& free, const VkMemoryRequirements& needs,
          VkDeviceSize& offset) {
  for (auto range = free.begin(); range != free.end(); ++range) {
    const VkDeviceSize begin = range->first;
    const VkDeviceSize end = begin + range->second;
    offset = round_up(begin, needs.alignment);
    if (offset > end || end - offset < needs.size) continue;
    free.erase(range);
    if (offset > begin) free[begin] = offset - begin;
    if (offset + needs.size < end) free[offset + needs.size] = end - offset - needs.size;
    return true;
  }
  return false;
}

// The first memory type among the `allowed` bits with all `wanted` properties; false if there is none.
bool find_memory_type(const VulkanHandles& handles, uint32_t allowed, VkMemoryPropertyFlags wanted,
                      uint32_t& type) {
  for (type = 0; type < handles.memory.memoryTypeCount; ++type) {
    if ((allowed >> type & 1u) && (handles.memory.memoryTypes[type].propertyFlags & wanted) == wanted)
      return true;
  }
  return false;
}

}  // namespace

VulkanMemory::~VulkanMemory() {
  for (Block& block : blocks_) give_back(block);
}

void VulkanMemory::give_back(Block& block) {
  handles_.vk.FreeMemory(handles_.device, block.memory, nullptr);
  handles_.memory_used -= block.bytes;
  block = {};
}

bool VulkanMemory::empty(const Block& block) {
  const auto whole = block.free.find(0);
  return block.bytes > 0 && whole != block.free.end() && whole->second == block.bytes;
}

void VulkanMemory::give_back_empty(size_t usual_kept) {
  for (Block& block : blocks_) {
    if (!empty(block)) continue;
    if (block.bytes == kBlockBytes && usual_kept > 0)
      --usual_kept;
    else
      give_back(block);
  }
}

Result<void> VulkanMemory::add_block(uint32_t type, VkDeviceSize bytes) {
  if (handles_.memory_limit > 0 && handles_.memory_used + bytes > handles_.memory_limit)
    return vulkan_error("vkAllocateMemory", VK_ERROR_OUT_OF_DEVICE_MEMORY);
  auto info = vulkan_info<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  info.allocationSize = bytes;
  info.memoryTypeIndex = type;
  Block block{VK_NULL_HANDLE, type, bytes, {{0, bytes}}};
  if (const VkResult made = handles_.vk.AllocateMemory(handles_.device, &info, nullptr, &block.memory);
      made != VK_SUCCESS) {
    return vulkan_error("vkAllocateMemory", made);
  }
  handles_.memory_used += bytes;
  blocks_.push_back(std::move(block));
  return {};
}

Result<VulkanMemory::Range> VulkanMemory::allocate(const VkMemoryRequirements& needs) {
  uint32_t type = 0;
  if (!find_memory_type(handles_, needs.memoryTypeBits, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, type) &&
      !find_memory_type(handles_, needs.memoryTypeBits, 0, type)) {
    return Error{ErrorCode::Unavailable,
                 "vulkan: the device has no memory type for buffers; check the driver"};
  }
  Range range{0, 0, needs.size};
  for (; range.block < blocks_.size(); ++range.block) {
    Block& block = blocks_[range.block];
    if (block.type == type && take(block.free, needs, range.offset)) return range;
  }
  auto added = add_block(type, std::max(kBlockBytes, needs.size));
  if (!added && added.error().code == ErrorCode::TooLarge) {
    give_back_empty(0);
    added = add_block(type, needs.size);
  }
  if (!added) return added.error();
  range.block = static_cast<uint32_t>(blocks_.size() - 1);
  take(blocks_.back().free, needs, range.offset);
  return range;
}

void VulkanMemory::free(const Range& range) {
  auto& free = blocks_[range.block].free;
  auto placed = free.emplace(range.offset, range.bytes).first;
  if (const auto next = std::next(placed);
      next != free.end() && placed->first + placed->second == next->first) {
    placed->second += next->second;
    free.erase(next);
  }
  if (placed != free.begin()) {
    const auto previous = std::prev(placed);
    if (previous->first + previous->second == placed->first) {
      previous->second += placed->second;
      free.erase(placed);
    }
  }
  if (empty(blocks_[range.block])) give_back_empty(1);
}

HostBuffer::~HostBuffer() {
  if (!handles_) return;
  handles_->vk.DestroyBuffer(handles_->device, buffer_, nullptr);
  handles_->vk.FreeMemory(handles_->device, memory_, nullptr);
}

Result<void> HostBuffer::create(const VulkanHandles& handles, VkDeviceSize bytes, VkBufferUsageFlags usage) {
  handles_ = &handles;
  const VulkanFunctions& vk = handles.vk;
  auto info = vulkan_info<VkBufferCreateInfo>(VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO);
  info.size = bytes;
  info.usage = usage;
  if (const VkResult made = vk.CreateBuffer(handles.device, &info, nullptr, &buffer_); made != VK_SUCCESS) {
    return vulkan_error("vkCreateBuffer", made);
  }
  VkMemoryRequirements needs;
  vk.GetBufferMemoryRequirements(handles.device, buffer_, &needs);
  // Vulkan guarantees coherent memory for buffers. Cached memory, if available, makes reading back fast.
  constexpr VkMemoryPropertyFlags kCoherent =
      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  auto allocation = vulkan_info<VkMemoryAllocateInfo>(VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO);
  allocation.allocationSize = needs.size;
  if (!find_memory_type(handles, needs.memoryTypeBits, kCoherent | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
                        allocation.memoryTypeIndex) &&
      !find_memory_type(handles, needs.memoryTypeBits, kCoherent, allocation.memoryTypeIndex)) {
    return Error{ErrorCode::Unavailable, "vulkan: the device has no host-visible memory; check the driver"};
  }
  if (const VkResult made = vk.AllocateMemory(handles.device, &allocation, nullptr, &memory_);
      made != VK_SUCCESS) {
    return vulkan_error("vkAllocateMemory", made);
  }
  if (const VkResult bound = vk.BindBufferMemory(handles.device, buffer_, memory_, 0); bound != VK_SUCCESS) {
    return vulkan_error("vkBindBufferMemory", bound);
  }
  void* mapped = nullptr;
  if (const VkResult done = vk.MapMemory(handles.device, memory_, 0, VK_WHOLE_SIZE, 0, &mapped);
      done != VK_SUCCESS) {
    return vulkan_error("vkMapMemory", done);
  }
  bytes_ = static_cast<std::byte*>(mapped);
  return {};
}

}  // namespace livegs
