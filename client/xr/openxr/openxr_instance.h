// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the .cpp files of this room: it shows OpenXR's and Vulkan's types.

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#include <time.h>

#include "compute/vulkan_maker.h"
// After Vulkan's:
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <memory>
#include <optional>
#include <string>

#include "core/pose.h"
#include "core/result.h"

namespace livegs {

// An empty structure of its type.
template <class T>
T openxr_info(XrStructureType type) {
  T info{};
  info.type = type;
  return info;
}

// The instance: which runtime there is, what of its extensions is used, its clock. One thread.
class OpenXrInstance {
 public:
  // Unavailable, with the remedy, when there is no runtime or one without Vulkan.
  static Result<std::unique_ptr<OpenXrInstance>> create();
  ~OpenXrInstance();
  OpenXrInstance(const OpenXrInstance&) = delete;
  OpenXrInstance& operator=(const OpenXrInstance&) = delete;

  XrInstance handle() const { return instance_; }
  const std::string& name() const { return name_; }  // the runtime's
  bool has_touch_plus() const { return touch_plus_; }
  bool has_refresh_rates() const { return get_refresh_rate != nullptr; }

  // The headset. Nothing while none is connected.
  Result<std::optional<XrSystemId>> find_headset();
  // Why all is over when the runtime goes, announced or not; with the remedy.
  Error gone() const;
  // OK, or the call and what OpenXR calls its result; gone() where that means that there is no runtime any
  // more.
  Result<void> check(XrResult result, const char* call) const;
  // A moment of OpenXR's clock by now_ns().
  int64_t moment_ns(XrTime time) const;
  XrPath path(const char* text) const;

  // Of extensions; the first four are always there.
  PFN_xrGetVulkanGraphicsRequirements2KHR get_requirements = nullptr;
  PFN_xrCreateVulkanInstanceKHR create_vulkan_instance = nullptr;
  PFN_xrGetVulkanGraphicsDevice2KHR get_vulkan_device = nullptr;
  PFN_xrCreateVulkanDeviceKHR create_vulkan_device = nullptr;
  PFN_xrGetDisplayRefreshRateFB get_refresh_rate = nullptr;
  PFN_xrConvertTimeToTimespecTimeKHR to_timespec = nullptr;

 private:
  OpenXrInstance() = default;
  template <class Function>
  bool load(const char* call, Function& function) const;

  XrInstance instance_ = XR_NULL_HANDLE;
  std::string name_;
  bool touch_plus_ = false;
};

// The device that the headset's pictures are made on.
class OpenXrVulkanMaker final : public VulkanMaker {
 public:
  OpenXrVulkanMaker(const OpenXrInstance& instance, XrSystemId system)
      : instance_(instance), system_(system) {}
  VkResult create_instance(PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo& info,
                           VkInstance* instance) override;
  VkPhysicalDevice choose(VkInstance instance) override;
  VkResult create_device(PFN_vkGetInstanceProcAddr get, VkPhysicalDevice physical,
                         const VkDeviceCreateInfo& info, VkDevice* device) override;

 private:
  const OpenXrInstance& instance_;
  XrSystemId system_;
};

Pose pose_from_openxr(const XrPosef& pose);
XrPosef openxr_from_pose(const Pose& pose);

}  // namespace livegs
