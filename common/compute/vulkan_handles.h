// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the .cpp files of this room, of client/render, which draws, and of client/xr: no other header shows
// Vulkan's.

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "core/result.h"

namespace livegs {

// Functions found by vkGetInstanceProcAddr once there is an instance.
// clang-format off
#define LIVEGS_VULKAN_FUNCTIONS(X)                                                                         \
  X(DestroyInstance) X(EnumeratePhysicalDevices) X(GetPhysicalDeviceProperties)                            \
  X(GetPhysicalDeviceFeatures2) X(GetPhysicalDeviceQueueFamilyProperties)                                  \
  X(GetPhysicalDeviceMemoryProperties) X(CreateDevice) X(DestroyDevice) X(DeviceWaitIdle)                  \
  X(GetDeviceQueue) X(AllocateMemory) X(FreeMemory) X(MapMemory) X(CreateBuffer) X(DestroyBuffer)          \
  X(GetBufferMemoryRequirements) X(BindBufferMemory) X(CreateShaderModule) X(DestroyShaderModule)          \
  X(CreateDescriptorSetLayout) X(DestroyDescriptorSetLayout) X(CreatePipelineLayout)                       \
  X(DestroyPipelineLayout) X(CreateComputePipelines) X(DestroyPipeline) X(CreateDescriptorPool)            \
  X(DestroyDescriptorPool) X(ResetDescriptorPool) X(AllocateDescriptorSets) X(UpdateDescriptorSets)        \
  X(CreateCommandPool) X(DestroyCommandPool) X(ResetCommandPool) X(AllocateCommandBuffers)                 \
  X(BeginCommandBuffer) X(EndCommandBuffer) X(CmdPipelineBarrier2) X(CmdBindPipeline)                      \
  X(CmdBindDescriptorSets) X(CmdPushConstants) X(CmdDispatch) X(CmdCopyBuffer) X(QueueSubmit2)             \
  X(CreateFence) X(DestroyFence) X(ResetFences) X(WaitForFences) X(CreateImage) X(DestroyImage)            \
  X(GetImageMemoryRequirements) X(BindImageMemory) X(CreateImageView) X(DestroyImageView)                  \
  X(CreateGraphicsPipelines) X(CmdBeginRendering) X(CmdEndRendering) X(CmdSetViewport) X(CmdSetScissor)    \
  X(CmdDraw) X(CmdDrawIndirect) X(CmdCopyImageToBuffer) X(GetPhysicalDeviceFormatProperties)      \
  X(CmdBlitImage) X(CmdCopyBufferToImage) X(CreateQueryPool) X(DestroyQueryPool) X(CmdResetQueryPool)     \
  X(CmdWriteTimestamp2) X(GetQueryPoolResults) X(CreatePipelineCache) X(DestroyPipelineCache)               \
  X(GetPipelineCacheData)
// clang-format on

struct VulkanFunctions {
#define LIVEGS_MEMBER(name) PFN_vk##name name = nullptr;
  LIVEGS_VULKAN_FUNCTIONS(LIVEGS_MEMBER)
#undef LIVEGS_MEMBER
  // Extension VK_EXT_debug_utils: null without the validation layer.
  PFN_vkCreateDebugUtilsMessengerEXT CreateDebugUtilsMessengerEXT = nullptr;
  PFN_vkDestroyDebugUtilsMessengerEXT DestroyDebugUtilsMessengerEXT = nullptr;
  PFN_vkCmdBeginDebugUtilsLabelEXT CmdBeginDebugUtilsLabelEXT = nullptr;
  PFN_vkCmdEndDebugUtilsLabelEXT CmdEndDebugUtilsLabelEXT = nullptr;
};

// Everything a device is made of; destroys it in the right order.
struct VulkanHandles {
  VulkanHandles() = default;
  ~VulkanHandles();
  VulkanHandles(const VulkanHandles&) = delete;
  VulkanHandles& operator=(const VulkanHandles&) = delete;

  VulkanFunctions vk;
  std::function<void(const std::string&)> on_validation_message;
  PFN_vkGetInstanceProcAddr get = nullptr;  // of the loader
  VkInstance instance = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
  VkPhysicalDevice physical_device = VK_NULL_HANDLE;
  VkPhysicalDeviceProperties properties{};
  VkPhysicalDeviceMemoryProperties memory{};
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;  // every pipeline of the device is made with it
  std::filesystem::path pipeline_cache_file;        // empty: it is not kept between runs
  std::string pipeline_cache_hash;  // content_hash of the data that the file holds; empty: none
  uint32_t queue_family = 0;
  bool draws = false;           // the queue draws as well, and multiview and dynamic rendering are on
  uint32_t timestamp_bits = 0;  // that count, of the queue's clock; 0: it has none
  VkDeviceSize memory_limit =
      0;  // bytes of device memory that VulkanMemory takes at most; 0: what the device grants
  mutable std::atomic<VkDeviceSize> memory_used{0};
  std::string name;
};

// An empty structure of its type.
template <class T>
T vulkan_info(VkStructureType type) {
  T info{};
  info.sType = type;
  return info;
}

// "vulkan: CALL failed (-4)": out of memory is TooLarge, all else Unavailable.
inline Error vulkan_error(const char* call, VkResult result) {
  const bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return {
      memory ? ErrorCode::TooLarge : ErrorCode::Unavailable,
      std::string("vulkan: ") + call + " failed with VkResult " + std::to_string(result) +
          (memory ? ": out of memory; use fewer or smaller buffers" : "; is the driver installed and well?")};
}

}  // namespace livegs
