// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "openxr_calls.h"

namespace livegs::simulated {

struct SwapchainImage {
  VkImage image = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

// clang-format off
#define SIMULATED_VULKAN_CALLS(X)                                                                                    \
  X(GetDeviceQueue) X(CreateImage) X(DestroyImage) X(GetImageMemoryRequirements) X(AllocateMemory) X(FreeMemory)     \
  X(BindImageMemory) X(CreateBuffer) X(DestroyBuffer) X(GetBufferMemoryRequirements) X(BindBufferMemory)             \
  X(MapMemory) X(CreateCommandPool) X(DestroyCommandPool) X(AllocateCommandBuffers) X(BeginCommandBuffer)            \
  X(EndCommandBuffer) X(CmdPipelineBarrier) X(CmdCopyImageToBuffer) X(QueueSubmit) X(QueueWaitIdle)                  \
  X(ResetCommandBuffer) X(DeviceWaitIdle)
// clang-format on

// The application's Vulkan device as the runtime uses it. Swapchain images are plain images of this device,
// used on its queue.
struct Graphics {
#define SIMULATED_MEMBER(name) PFN_vk##name name = nullptr;
  SIMULATED_VULKAN_CALLS(SIMULATED_MEMBER)
#undef SIMULATED_MEMBER
  VkDevice device = VK_NULL_HANDLE;
  VkQueue queue = VK_NULL_HANDLE;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkPhysicalDeviceMemoryProperties memory{};
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory buffer_memory = VK_NULL_HANDLE;
  uint8_t* bytes = nullptr;
  VkDeviceSize capacity = 0;

  bool open(PFN_vkGetInstanceProcAddr get, const XrGraphicsBindingVulkan2KHR& binding);
  void close();
  // Creates colour images with array layers, in COLOR_ATTACHMENT_OPTIMAL.
  bool make_image(const XrSwapchainCreateInfo& info, SwapchainImage& made);
  void destroy(SwapchainImage& image);
  // Reads one layer of an image with 4 bytes per pixel. The image stays in COLOR_ATTACHMENT_OPTIMAL.
  bool read(VkImage image, uint32_t layer, const XrRect2Di& rect, std::vector<uint8_t>& bytes);

 private:
  bool allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags flags, VkDeviceMemory& memory);
  void barrier(VkImage image, VkImageLayout from, VkImageLayout to, VkAccessFlags before,
               VkAccessFlags after);
  bool begin();
  bool run();
};

}  // namespace livegs::simulated
