// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the .cpp files of this room, of client/render and of client/xr only: it exposes the Vulkan headers.

#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>

#include <atomic>
#include <filesystem>
#include <functional>
#include <string>

#include "core/result.h"

namespace livegs {

// Functions loaded with vkGetInstanceProcAddr once an instance exists.
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

// All Vulkan objects of a device; destroys them in the right order.
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
  VkPipelineCache pipeline_cache = VK_NULL_HANDLE;  // used for every pipeline of the device
  std::filesystem::path pipeline_cache_file;        // empty: the cache is not saved
  std::string pipeline_cache_hash;                  // content_hash of the data in the file; empty: none
  uint32_t queue_family = 0;
  bool draws = false;  // the queue supports graphics, and multiview and dynamic rendering are enabled
  uint32_t timestamp_bits = 0;    // valid bits of the timestamps of the queue; 0: none
  VkDeviceSize memory_limit = 0;  // limit of the device memory of VulkanMemory, bytes; 0: no limit
  mutable std::atomic<VkDeviceSize> memory_used{0};
  std::string name;
};

// An empty Vulkan structure with its type set.
template <class T>
T vulkan_info(VkStructureType type) {
  T info{};
  info.sType = type;
  return info;
}

// Builds "vulkan: CALL failed (-4)". Out of memory gives TooLarge, all other results Unavailable.
inline Error vulkan_error(const char* call, VkResult result) {
  const bool memory = result == VK_ERROR_OUT_OF_HOST_MEMORY || result == VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return {memory ? ErrorCode::TooLarge : ErrorCode::Unavailable,
          std::string("vulkan: ") + call + " failed with VkResult " + std::to_string(result) +
              (memory ? ": out of memory; use fewer or smaller buffers"
                      : "; check that the driver is installed and works")};
}

}  // namespace livegs
