// SPDX-License-Identifier: Apache-2.0
// XR_KHR_vulkan_enable2, and reading back of images.
#include "graphics.h"

#include <cstring>

#include "runtime.h"

namespace livegs::simulated {

bool Graphics::open(PFN_vkGetInstanceProcAddr get, const XrGraphicsBindingVulkan2KHR& binding) {
  device = binding.device;
  const auto of_device =
      reinterpret_cast<PFN_vkGetDeviceProcAddr>(get(binding.instance, "vkGetDeviceProcAddr"));
  const auto of_memory = reinterpret_cast<PFN_vkGetPhysicalDeviceMemoryProperties>(
      get(binding.instance, "vkGetPhysicalDeviceMemoryProperties"));
  if (!of_device || !of_memory) return false;
#define SIMULATED_LOAD(name) name = reinterpret_cast<PFN_vk##name>(of_device(device, "vk" #name));
  SIMULATED_VULKAN_CALLS(SIMULATED_LOAD)
#undef SIMULATED_LOAD
  of_memory(binding.physicalDevice, &memory);
  GetDeviceQueue(device, binding.queueFamilyIndex, binding.queueIndex, &queue);
  VkCommandPoolCreateInfo info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr,
                               VK_COMMAND_POOL_CREATE_RESET_COMMAND_BUFFER_BIT, binding.queueFamilyIndex};
  if (CreateCommandPool(device, &info, nullptr, &pool) != VK_SUCCESS) return false;
  VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr, pool,
                                       VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
  return AllocateCommandBuffers(device, &allocate, &commands) == VK_SUCCESS;
}

void Graphics::close() {
  if (!device) return;
  DeviceWaitIdle(device);
  if (buffer) DestroyBuffer(device, buffer, nullptr);
  if (buffer_memory) FreeMemory(device, buffer_memory, nullptr);
  if (pool) DestroyCommandPool(device, pool, nullptr);
  *this = Graphics();
}

bool Graphics::allocate(const VkMemoryRequirements& needs, VkMemoryPropertyFlags flags,
                        VkDeviceMemory& made) {
  for (uint32_t type = 0; type < memory.memoryTypeCount; ++type) {
    if (!(needs.memoryTypeBits & (1u << type)) || (memory.memoryTypes[type].propertyFlags & flags) != flags)
      continue;
    const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, needs.size, type};
    return AllocateMemory(device, &info, nullptr, &made) == VK_SUCCESS;
  }
  return false;
}

bool Graphics::begin() {
  ResetCommandBuffer(commands, 0);
  const VkCommandBufferBeginInfo info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO, nullptr,
                                      VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT, nullptr};
  return BeginCommandBuffer(commands, &info) == VK_SUCCESS;
}

bool Graphics::run() {
  EndCommandBuffer(commands);
  VkSubmitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands;
  return QueueSubmit(queue, 1, &info, VK_NULL_HANDLE) == VK_SUCCESS && QueueWaitIdle(queue) == VK_SUCCESS;
}

void Graphics::barrier(VkImage image, VkImageLayout from, VkImageLayout to, VkAccessFlags before,
                       VkAccessFlags after) {
  VkImageMemoryBarrier barrier{};
  barrier.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER;
  barrier.srcAccessMask = before;
  barrier.dstAccessMask = after;
  barrier.oldLayout = from;
  barrier.newLayout = to;
  barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  barrier.image = image;
  barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, VK_REMAINING_MIP_LEVELS, 0,
                              VK_REMAINING_ARRAY_LAYERS};
  CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0,
                     nullptr, 0, nullptr, 1, &barrier);
}

bool Graphics::make_image(const XrSwapchainCreateInfo& info, SwapchainImage& made) {
  VkImageCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  create.imageType = VK_IMAGE_TYPE_2D;
  create.format = static_cast<VkFormat>(info.format);
  create.extent = {info.width, info.height, 1};
  create.mipLevels = info.mipCount;
  create.arrayLayers = info.arraySize;
  create.samples = VK_SAMPLE_COUNT_1_BIT;
  create.tiling = VK_IMAGE_TILING_OPTIMAL;
  create.usage = VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
  if (info.usageFlags & XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT)
    create.usage |= VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
  if (info.usageFlags & XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT) create.usage |= VK_IMAGE_USAGE_TRANSFER_DST_BIT;
  if (info.usageFlags & XR_SWAPCHAIN_USAGE_SAMPLED_BIT) create.usage |= VK_IMAGE_USAGE_SAMPLED_BIT;
  if (CreateImage(device, &create, nullptr, &made.image) != VK_SUCCESS) return false;
  VkMemoryRequirements needs;
  GetImageMemoryRequirements(device, made.image, &needs);
  if (!allocate(needs, 0, made.memory) || BindImageMemory(device, made.image, made.memory, 0) != VK_SUCCESS ||
      !begin())
    return false;
  barrier(made.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, 0,
          VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT);
  return run();
}

void Graphics::destroy(SwapchainImage& image) {
  DestroyImage(device, image.image, nullptr);
  FreeMemory(device, image.memory, nullptr);
}

bool Graphics::read(VkImage image, uint32_t layer, const XrRect2Di& rect, std::vector<uint8_t>& read) {
  const VkDeviceSize wanted =
      VkDeviceSize{4} * static_cast<uint32_t>(rect.extent.width) * static_cast<uint32_t>(rect.extent.height);
  if (wanted > capacity) {
    if (buffer) DestroyBuffer(device, buffer, nullptr);
    if (buffer_memory) FreeMemory(device, buffer_memory, nullptr);
    buffer = VK_NULL_HANDLE;
    buffer_memory = VK_NULL_HANDLE;
    VkBufferCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
    create.size = capacity = wanted;
    create.usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    if (CreateBuffer(device, &create, nullptr, &buffer) != VK_SUCCESS) return false;
    VkMemoryRequirements needs;
    GetBufferMemoryRequirements(device, buffer, &needs);
    void* mapped = nullptr;
    if (!allocate(needs, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                  buffer_memory) ||
        BindBufferMemory(device, buffer, buffer_memory, 0) != VK_SUCCESS ||
        MapMemory(device, buffer_memory, 0, VK_WHOLE_SIZE, 0, &mapped) != VK_SUCCESS)
      return false;
    bytes = static_cast<uint8_t*>(mapped);
  }
  if (!begin()) return false;
  barrier(image, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
          VK_ACCESS_MEMORY_WRITE_BIT, VK_ACCESS_TRANSFER_READ_BIT);
  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, layer, 1};
  copy.imageOffset = {rect.offset.x, rect.offset.y, 0};
  copy.imageExtent = {static_cast<uint32_t>(rect.extent.width), static_cast<uint32_t>(rect.extent.height), 1};
  CmdCopyImageToBuffer(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer, 1, &copy);
  barrier(image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
          VK_ACCESS_TRANSFER_READ_BIT, VK_ACCESS_COLOR_ATTACHMENT_WRITE_BIT);
  VkMemoryBarrier host{VK_STRUCTURE_TYPE_MEMORY_BARRIER, nullptr, VK_ACCESS_TRANSFER_WRITE_BIT,
                       VK_ACCESS_HOST_READ_BIT};
  CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &host, 0,
                     nullptr, 0, nullptr);
  if (!run()) return false;
  read.assign(bytes, bytes + wanted);
  return true;
}

}  // namespace livegs::simulated

using namespace livegs::simulated;

XrResult xrGetVulkanGraphicsRequirements2KHR(XrInstance instance, XrSystemId system,
                                             XrGraphicsRequirementsVulkanKHR* requirements) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrGetVulkanGraphicsRequirements2KHR: no such instance");
  if (system != kSystem)
    return misuse(XR_ERROR_SYSTEM_INVALID, "xrGetVulkanGraphicsRequirements2KHR: no such system");
  requirements->minApiVersionSupported = XR_MAKE_VERSION(1, 0, 0);
  requirements->maxApiVersionSupported = XR_MAKE_VERSION(1, 3, 999);
  found->requirements_asked = true;
  return XR_SUCCESS;
}

XrResult xrCreateVulkanInstanceKHR(XrInstance instance, const XrVulkanInstanceCreateInfoKHR* info,
                                   VkInstance* made, VkResult* result) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrCreateVulkanInstanceKHR: no such instance");
  if (!info || info->systemId != kSystem || !info->pfnGetInstanceProcAddr || !info->vulkanCreateInfo)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateVulkanInstanceKHR: the info is incomplete");
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(
      info->pfnGetInstanceProcAddr(VK_NULL_HANDLE, "vkCreateInstance"));
  *result = create(info->vulkanCreateInfo, info->vulkanAllocator, made);
  if (*result == VK_SUCCESS) {
    found->vulkan = *made;
    found->vulkan_of = info->pfnGetInstanceProcAddr;
  }
  return XR_SUCCESS;
}

XrResult xrGetVulkanGraphicsDevice2KHR(XrInstance instance, const XrVulkanGraphicsDeviceGetInfoKHR* info,
                                       VkPhysicalDevice* device) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrGetVulkanGraphicsDevice2KHR: no such instance");
  if (!info || info->systemId != kSystem || !found->vulkan || info->vulkanInstance != found->vulkan)
    return misuse(
        XR_ERROR_VALIDATION_FAILURE,
        "xrGetVulkanGraphicsDevice2KHR: the Vulkan instance was not created by xrCreateVulkanInstanceKHR");
  const auto enumerate = reinterpret_cast<PFN_vkEnumeratePhysicalDevices>(
      found->vulkan_of(found->vulkan, "vkEnumeratePhysicalDevices"));
  uint32_t count = 1;
  const VkResult result = enumerate(found->vulkan, &count, device);
  return (result == VK_SUCCESS || result == VK_INCOMPLETE) && count == 1 ? XR_SUCCESS
                                                                         : XR_ERROR_RUNTIME_FAILURE;
}

XrResult xrCreateVulkanDeviceKHR(XrInstance instance, const XrVulkanDeviceCreateInfoKHR* info, VkDevice* made,
                                 VkResult* result) {
  std::lock_guard lock(runtime().mutex);
  Instance* found = find(instance);
  if (!found) return misuse(XR_ERROR_HANDLE_INVALID, "xrCreateVulkanDeviceKHR: no such instance");
  if (!info || info->systemId != kSystem || !info->pfnGetInstanceProcAddr || !info->vulkanPhysicalDevice ||
      !info->vulkanCreateInfo)
    return misuse(XR_ERROR_VALIDATION_FAILURE, "xrCreateVulkanDeviceKHR: the info is incomplete");
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(found->vulkan_of(found->vulkan, "vkCreateDevice"));
  *result = create(info->vulkanPhysicalDevice, info->vulkanCreateInfo, info->vulkanAllocator, made);
  return XR_SUCCESS;
}
