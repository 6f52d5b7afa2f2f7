// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "compute/device_image.h"
#include "compute/vulkan_memory.h"
#include "splat/image.h"
#include "xr/openxr/openxr_instance.h"

namespace livegs {

// A swapchain in sRGB: one layer per eye, or a single layer. One thread.
class OpenXrSwapchain {
 public:
  explicit OpenXrSwapchain(const VulkanHandles& handles) : handles_(handles) {}
  ~OpenXrSwapchain();
  OpenXrSwapchain(const OpenXrSwapchain&) = delete;
  OpenXrSwapchain& operator=(const OpenXrSwapchain&) = delete;

  // Call once. XR_ERROR_SWAPCHAIN_FORMAT_UNSUPPORTED if the runtime has no 8-bit sRGB format.
  XrResult create(XrSession session, int width, int height, int layers = 2);
  XrSwapchain handle() const { return swapchain_; }
  bool acquired() const { return acquired_.has_value(); }

  // Waits until an image is free, without a timeout.
  XrResult acquire(DeviceImage& image);
  // Copies pictures drawn elsewhere into the acquired image at its top left, one per layer.
  Result<void> upload(std::span<const Image> images);
  // Copies one picture of display-encoded RGBA bytes.
  Result<void> upload(std::span<const uint8_t> rgba, int width, int height);
  XrResult release();

 private:
  Result<void> prepare_upload(VkDeviceSize bytes);
  Result<void> copy_staged(int width, int height, uint32_t layers);

  const VulkanHandles& handles_;
  XrSwapchain swapchain_ = XR_NULL_HANDLE;
  std::vector<VkImage> images_;
  int width_ = 0, height_ = 0, layers_ = 0;
  bool bgra_ = false;
  std::optional<uint32_t> acquired_;
  // State of uploads.
  VkCommandPool pool_ = VK_NULL_HANDLE;
  VkCommandBuffer commands_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  std::optional<HostBuffer> staging_;
  VkDeviceSize staging_bytes_ = 0;
};

}  // namespace livegs
