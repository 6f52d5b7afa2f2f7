// SPDX-License-Identifier: Apache-2.0
#pragma once

struct VkImage_T;  // target of the Vulkan handle VkImage

namespace livegs {

// An external image on a VulkanDevice (of a headset) to draw into: one layer per eye, in layout
// COLOR_ATTACHMENT_OPTIMAL before and after. It may be larger than the drawn area, which is at its top left.
struct DeviceImage {
  VkImage_T* image = nullptr;
  int width = 0, height = 0, layers = 0;
};

}  // namespace livegs
