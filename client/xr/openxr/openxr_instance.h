// SPDX-License-Identifier: Apache-2.0
#pragma once

// Internal to this room: exposes the types of OpenXR and Vulkan.

#define XR_USE_GRAPHICS_API_VULKAN
#define XR_USE_TIMESPEC
#include <time.h>

#include "compute/vulkan_maker.h"
// After Vulkan's headers:
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <memory>
#include <optional>
#include <string>

#include "core/pose.h"
#include "core/result.h"

namespace livegs {

// Returns an empty structure with its type set.
template <class T>
T openxr_info(XrStructureType type) {
  T info{};
  info.type = type;
  return info;
}

// The OpenXR instance: the runtime, its extensions and its clock. One thread.
class OpenXrInstance {
 public:
  // Unavailable, with the remedy, when there is no runtime or one without Vulkan.
  static Result<std::unique_ptr<OpenXrInstance>> create();
  ~OpenXrInstance();
  OpenXrInstance(const OpenXrInstance&) = delete;
  OpenXrInstance& operator=(const OpenXrInstance&) = delete;

  XrInstance handle() const { return instance_; }
  const std::string& name() const { return name_; }  // name of the runtime
  bool has_touch_plus() const { return touch_plus_; }
  bool has_refresh_rates() const { return get_refresh_rate != nullptr; }

  // Finds the headset. Nothing if none is connected.
  Result<std::optional<XrSystemId>> find_headset();
  // The error for a runtime that shut down, announced or not; with the remedy.
  Error gone() const;
  // OK, or an error with the call and the name of the result; gone() if the runtime is no longer available.
  Result<void> check(XrResult result, const char* call) const;
  // Converts an OpenXR time to now_ns() time.
  int64_t moment_ns(XrTime time) const;
  XrPath path(const char* text) const;

  // Extension functions; the first four are always available.
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

// Creates the Vulkan device that renders for the headset.
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
