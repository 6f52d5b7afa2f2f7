// SPDX-License-Identifier: Apache-2.0
#include "xr/openxr/openxr_swapchain.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace livegs {
namespace {

uint8_t byte_of(float value) {
  return static_cast<uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

void barrier(const VulkanFunctions& vk, VkCommandBuffer commands, VkImage image, uint32_t layers,
             VkImageLayout from, VkImageLayout to) {
  auto info = vulkan_info<VkImageMemoryBarrier2>(VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2);
  info.srcStageMask = info.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  info.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  info.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  info.oldLayout = from;
  info.newLayout = to;
  info.srcQueueFamilyIndex = info.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
  info.image = image;
  info.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, layers};
  auto dependency = vulkan_info<VkDependencyInfo>(VK_STRUCTURE_TYPE_DEPENDENCY_INFO);
  dependency.imageMemoryBarrierCount = 1;
  dependency.pImageMemoryBarriers = &info;
  vk.CmdPipelineBarrier2(commands, &dependency);
}

}  // namespace

OpenXrSwapchain::~OpenXrSwapchain() {
  if (fence_) handles_.vk.DestroyFence(handles_.device, fence_, nullptr);
  if (pool_) handles_.vk.DestroyCommandPool(handles_.device, pool_, nullptr);
  if (swapchain_) xrDestroySwapchain(swapchain_);
}

XrResult OpenXrSwapchain::create(XrSession session, int width, int height, int layers) {
  uint32_t count = 0;
  if (const XrResult result = xrEnumerateSwapchainFormats(session, 0, &count, nullptr); XR_FAILED(result))
    return result;
  std::vector<int64_t> formats(count);
  if (const XrResult result = xrEnumerateSwapchainFormats(session, count, &count, formats.data());
      XR_FAILED(result))
    return result;
  const auto format =
      std::find_if(formats.begin(), formats.end(), [](int64_t one) {  // sorted by the runtime's preference
        return one == VK_FORMAT_R8G8B8A8_SRGB || one == VK_FORMAT_B8G8R8A8_SRGB;
      });
  if (format == formats.end()) return XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED;
  auto info = openxr_info<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
  info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT | XR_SWAPCHAIN_USAGE_TRANSFER_DST_BIT;
  info.format = *format;
  info.sampleCount = info.faceCount = info.mipCount = 1;
  info.width = static_cast<uint32_t>(width);
  info.height = static_cast<uint32_t>(height);
  info.arraySize = static_cast<uint32_t>(layers);
  if (const XrResult result = xrCreateSwapchain(session, &info, &swapchain_); XR_FAILED(result))
    return result;
  width_ = width;
  height_ = height;
  layers_ = layers;
  bgra_ = *format == VK_FORMAT_B8G8R8A8_SRGB;
  if (const XrResult result = xrEnumerateSwapchainImages(swapchain_, 0, &count, nullptr); XR_FAILED(result))
    return result;
  std::vector<XrSwapchainImageVulkan2KHR> images(
      count, openxr_info<XrSwapchainImageVulkan2KHR>(XR_TYPE_SWAPCHAIN_IMAGE_VULKAN2_KHR));
  const XrResult result = xrEnumerateSwapchainImages(
      swapchain_, count, &count, reinterpret_cast<XrSwapchainImageBaseHeader*>(images.data()));
  for (const XrSwapchainImageVulkan2KHR& image : images) images_.push_back(image.image);
  return result;
}

XrResult OpenXrSwapchain::acquire(DeviceImage& image) {
  const auto info = openxr_info<XrSwapchainImageAcquireInfo>(XR_TYPE_SWAPCHAIN_IMAGE_ACQUIRE_INFO);
  uint32_t index = 0;
  if (const XrResult result = xrAcquireSwapchainImage(swapchain_, &info, &index); XR_FAILED(result))
    return result;
  acquired_ = index;
  auto wait = openxr_info<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  wait.timeout = XR_INFINITE_DURATION;
  image = {images_[index], width_, height_, layers_};
  return xrWaitSwapchainImage(swapchain_, &wait);
}

XrResult OpenXrSwapchain::release() {
  acquired_.reset();
  const auto info = openxr_info<XrSwapchainImageReleaseInfo>(XR_TYPE_SWAPCHAIN_IMAGE_RELEASE_INFO);
  return xrReleaseSwapchainImage(swapchain_, &info);
}

Result<void> OpenXrSwapchain::prepare_upload(VkDeviceSize bytes) {
  const VulkanFunctions& vk = handles_.vk;
  if (!pool_) {
    auto pool = vulkan_info<VkCommandPoolCreateInfo>(VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO);
    pool.queueFamilyIndex = handles_.queue_family;
    if (const VkResult made = vk.CreateCommandPool(handles_.device, &pool, nullptr, &pool_);
        made != VK_SUCCESS)
      return vulkan_error("vkCreateCommandPool", made);
    auto buffers = vulkan_info<VkCommandBufferAllocateInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO);
    buffers.commandPool = pool_;
    buffers.commandBufferCount = 1;
    if (const VkResult made = vk.AllocateCommandBuffers(handles_.device, &buffers, &commands_);
        made != VK_SUCCESS)
      return vulkan_error("vkAllocateCommandBuffers", made);
    const auto fence = vulkan_info<VkFenceCreateInfo>(VK_STRUCTURE_TYPE_FENCE_CREATE_INFO);
    if (const VkResult made = vk.CreateFence(handles_.device, &fence, nullptr, &fence_); made != VK_SUCCESS)
      return vulkan_error("vkCreateFence", made);
  }
  if (bytes > staging_bytes_) {
    staging_.emplace();
    if (auto made = staging_->create(handles_, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT); !made) return made;
    staging_bytes_ = bytes;
  }
  return {};
}

Result<void> OpenXrSwapchain::upload(std::span<const Image> images) {
  const Image& first = images[0];
  const size_t eye_bytes = size_t{4} * first.width * first.height;
  if (auto ready = prepare_upload(images.size() * eye_bytes); !ready) return ready;
  for (size_t e = 0; e < images.size(); ++e) {
    auto* to = reinterpret_cast<uint8_t*>(staging_->bytes()) + e * eye_bytes;
    for (size_t i = 0; i < eye_bytes; i += 4) {
      const float* pixel = images[e].pixels.data() + i;
      to[i] = byte_of(pixel[bgra_ ? 2 : 0]);
      to[i + 1] = byte_of(pixel[1]);
      to[i + 2] = byte_of(pixel[bgra_ ? 0 : 2]);
      to[i + 3] = 255;
    }
  }
  return copy_staged(first.width, first.height, static_cast<uint32_t>(images.size()));
}

Result<void> OpenXrSwapchain::upload(std::span<const uint8_t> rgba, int width, int height) {
  if (auto ready = prepare_upload(rgba.size()); !ready) return ready;
  auto* to = reinterpret_cast<uint8_t*>(staging_->bytes());
  std::copy(rgba.begin(), rgba.end(), to);
  for (size_t i = 0; bgra_ && i < rgba.size(); i += 4) std::swap(to[i], to[i + 2]);
  return copy_staged(width, height, 1);
}

Result<void> OpenXrSwapchain::copy_staged(int width, int height, uint32_t layers) {
  const VulkanFunctions& vk = handles_.vk;
  vk.ResetCommandPool(handles_.device, pool_, 0);
  const auto begin = vulkan_info<VkCommandBufferBeginInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO);
  vk.BeginCommandBuffer(commands_, &begin);
  const VkImage image = images_[*acquired_];
  barrier(vk, commands_, image, static_cast<uint32_t>(layers_), VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
          VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
  VkBufferImageCopy copy{};
  copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, layers};
  copy.imageExtent = {static_cast<uint32_t>(width), static_cast<uint32_t>(height), 1};
  vk.CmdCopyBufferToImage(commands_, staging_->buffer(), image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1,
                          &copy);
  barrier(vk, commands_, image, static_cast<uint32_t>(layers_), VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
          VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL);
  vk.EndCommandBuffer(commands_);
  auto commands = vulkan_info<VkCommandBufferSubmitInfo>(VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO);
  commands.commandBuffer = commands_;
  auto submit = vulkan_info<VkSubmitInfo2>(VK_STRUCTURE_TYPE_SUBMIT_INFO_2);
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &commands;
  if (const VkResult done = vk.QueueSubmit2(handles_.queue, 1, &submit, fence_); done != VK_SUCCESS)
    return vulkan_error("vkQueueSubmit2", done);
  if (const VkResult done =
          vk.WaitForFences(handles_.device, 1, &fence_, VK_TRUE, std::numeric_limits<uint64_t>::max());
      done != VK_SUCCESS)
    return vulkan_error("vkWaitForFences", done);
  vk.ResetFences(handles_.device, 1, &fence_);
  return {};
}

}  // namespace livegs
