// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the .cpp files of this room and of client/xr: it shows Vulkan's types.

#include "compute/vulkan_handles.h"

namespace livegs {

// Someone else who makes the instance and the device from what VulkanDevice asks for, and says which device:
// OpenXR's runtime (XR_KHR_vulkan_enable2), which may add to it. Called while VulkanDevice::create runs, on
// its thread.
class VulkanMaker {
 public:
  virtual ~VulkanMaker() = default;
  virtual VkResult create_instance(PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo& info,
                                   VkInstance* instance) = 0;
  virtual VkPhysicalDevice choose(VkInstance instance) = 0;  // null where there is none
  virtual VkResult create_device(PFN_vkGetInstanceProcAddr get, VkPhysicalDevice physical,
                                 const VkDeviceCreateInfo& info, VkDevice* device) = 0;
};

}  // namespace livegs
