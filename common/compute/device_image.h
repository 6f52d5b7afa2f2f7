// SPDX-License-Identifier: Apache-2.0
#pragma once

struct VkImage_T;  // what Vulkan's handle VkImage points to

namespace livegs {

// An image of someone else's on a VulkanDevice, a headset's, to be drawn into: a layer an eye, in the layout
// COLOR_ATTACHMENT_OPTIMAL before and after. It may be larger than what is drawn, which lies at its top left.
struct DeviceImage {
  VkImage_T* image = nullptr;
  int width = 0, height = 0, layers = 0;
};

}  // namespace livegs
