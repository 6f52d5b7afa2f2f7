// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the .cpp files of this room and of client/xr only: it exposes Vulkan types.

#include "compute/vulkan_handles.h"

namespace livegs {

// External creator of the instance and the device: the OpenXR runtime (XR_KHR_vulkan_enable2), which may add
// to the requested features and selects the physical device. Called during VulkanDevice::create, on its
// thread.
class VulkanMaker {
 public:
  virtual ~VulkanMaker() = default;
  virtual VkResult create_instance(PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo& info,
                                   VkInstance* instance) = 0;
  virtual VkPhysicalDevice choose(VkInstance instance) = 0;  // null if there is none
  virtual VkResult create_device(PFN_vkGetInstanceProcAddr get, VkPhysicalDevice physical,
                                 const VkDeviceCreateInfo& info, VkDevice* device) = 0;
};

}  // namespace livegs
