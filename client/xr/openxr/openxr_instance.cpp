// SPDX-License-Identifier: Apache-2.0
#include "xr/openxr/openxr_instance.h"

#include <cstdio>
#include <cstdlib>
#include <set>
#include <vector>

#include "core/clock.h"
#include "core/log.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

constexpr const char* kTouchPlus = "XR_META_touch_controller_plus";  // missing in Debian's header
constexpr const char* kRemedy =
    "start one (SteamVR, Monado, WiVRn) and make it the active one, or name its manifest in XR_RUNTIME_JSON";

std::set<std::string> extensions() {
  uint32_t count = 0;
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, 0, &count, nullptr))) return {};
  std::vector<XrExtensionProperties> all(count,
                                         openxr_info<XrExtensionProperties>(XR_TYPE_EXTENSION_PROPERTIES));
  if (XR_FAILED(xrEnumerateInstanceExtensionProperties(nullptr, count, &count, all.data()))) return {};
  std::set<std::string> names;
  for (const XrExtensionProperties& extension : all) names.insert(extension.extensionName);
  return names;
}

}  // namespace

template <class Function>
bool OpenXrInstance::load(const char* call, Function& function) const {
  return XR_SUCCEEDED(
      xrGetInstanceProcAddr(instance_, call, reinterpret_cast<PFN_xrVoidFunction*>(&function)));
}

Result<std::unique_ptr<OpenXrInstance>> OpenXrInstance::create() {
  ::setenv("XR_LOADER_DEBUG", "none", 0);  // the loader's message is part of the error below
  const std::set<std::string> there = extensions();
  if (there.empty())
    return Error{ErrorCode::Unavailable, format_text("openxr: no runtime is active; %s", kRemedy)};
  if (!there.contains(XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME))
    return Error{ErrorCode::Unavailable,
                 format_text("openxr: the active runtime has no XR_KHR_vulkan_enable2; %s", kRemedy)};
  std::vector<const char*> used = {XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME};
  for (const char* wanted :
       {XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME, XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME, kTouchPlus}) {
    if (there.contains(wanted)) used.push_back(wanted);
  }
  std::unique_ptr<OpenXrInstance> made(new OpenXrInstance);
  auto info = openxr_info<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::snprintf(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE, "LiveGS");
  std::snprintf(info.applicationInfo.engineName, XR_MAX_ENGINE_NAME_SIZE, "LiveGS");
  info.applicationInfo.apiVersion = XR_CURRENT_API_VERSION;
  info.enabledExtensionCount = static_cast<uint32_t>(used.size());
  info.enabledExtensionNames = used.data();
  if (const XrResult result = xrCreateInstance(&info, &made->instance_); XR_FAILED(result)) {
    made->instance_ = XR_NULL_HANDLE;
    return Error{ErrorCode::Unavailable,
                 format_text("openxr: the runtime failed to start (XrResult %d); %s", result, kRemedy)};
  }
  auto properties = openxr_info<XrInstanceProperties>(XR_TYPE_INSTANCE_PROPERTIES);
  if (XR_SUCCEEDED(xrGetInstanceProperties(made->instance_, &properties)))
    made->name_ = properties.runtimeName;
  made->touch_plus_ = there.contains(kTouchPlus);
  if (!made->load("xrGetVulkanGraphicsRequirements2KHR", made->get_requirements) ||
      !made->load("xrCreateVulkanInstanceKHR", made->create_vulkan_instance) ||
      !made->load("xrGetVulkanGraphicsDevice2KHR", made->get_vulkan_device) ||
      !made->load("xrCreateVulkanDeviceKHR", made->create_vulkan_device))
    return Error{ErrorCode::Unavailable, format_text("openxr: %s lacks calls of XR_KHR_vulkan_enable2; %s",
                                                     made->name_.c_str(), kRemedy)};
  if (there.contains(XR_FB_DISPLAY_REFRESH_RATE_EXTENSION_NAME))
    made->load("xrGetDisplayRefreshRateFB", made->get_refresh_rate);
  if (there.contains(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME))
    made->load("xrConvertTimeToTimespecTimeKHR", made->to_timespec);
  return made;
}

OpenXrInstance::~OpenXrInstance() {
  if (instance_) xrDestroyInstance(instance_);
}

Result<std::optional<XrSystemId>> OpenXrInstance::find_headset() {
  auto info = openxr_info<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  info.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  const XrResult result = xrGetSystem(instance_, &info, &system);
  if (result == XR_ERROR_FORM_FACTOR_UNAVAILABLE) return std::optional<XrSystemId>();
  if (auto found = check(result, "xrGetSystem"); !found) return found.error();
  return std::optional<XrSystemId>(system);
}

Error OpenXrInstance::gone() const {
  return {ErrorCode::Unavailable, "openxr: " + name_ + " is shutting down; restart it and the client"};
}

Result<void> OpenXrInstance::check(XrResult result, const char* call) const {
  if (XR_SUCCEEDED(result)) return {};
  if (result == XR_ERROR_INSTANCE_LOST || result == XR_ERROR_RUNTIME_UNAVAILABLE) return gone();
  char name[XR_MAX_RESULT_STRING_SIZE] = "";
  xrResultToString(instance_, result, name);
  return Error{ErrorCode::Unavailable,
               format_text("openxr: %s failed with %s (%s)", call, name, name_.c_str())};
}

int64_t OpenXrInstance::moment_ns(XrTime time) const {
  timespec moment{};
  if (to_timespec && XR_SUCCEEDED(to_timespec(instance_, time, &moment)))
    return int64_t{moment.tv_sec} * 1'000'000'000 + moment.tv_nsec;
  return now_ns();
}

XrPath OpenXrInstance::path(const char* text) const {
  XrPath made = XR_NULL_PATH;
  if (XR_FAILED(xrStringToPath(instance_, text, &made)))
    log_warn("openxr: %s is not a valid path in %s; update the runtime", text, name_.c_str());
  return made;
}

VkResult OpenXrVulkanMaker::create_instance(PFN_vkGetInstanceProcAddr get, const VkInstanceCreateInfo& info,
                                            VkInstance* made) {
  auto asked = openxr_info<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR);
  if (XR_FAILED(instance_.get_requirements(instance_.handle(), system_, &asked)))
    return VK_ERROR_INITIALIZATION_FAILED;
  auto create = openxr_info<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
  create.systemId = system_;
  create.pfnGetInstanceProcAddr = get;
  create.vulkanCreateInfo = &info;
  VkResult result = VK_ERROR_INITIALIZATION_FAILED;
  if (XR_FAILED(instance_.create_vulkan_instance(instance_.handle(), &create, made, &result)))
    return VK_ERROR_INITIALIZATION_FAILED;
  return result;
}

VkPhysicalDevice OpenXrVulkanMaker::choose(VkInstance vulkan) {
  auto get = openxr_info<XrVulkanGraphicsDeviceGetInfoKHR>(XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
  get.systemId = system_;
  get.vulkanInstance = vulkan;
  VkPhysicalDevice chosen = VK_NULL_HANDLE;
  return XR_SUCCEEDED(instance_.get_vulkan_device(instance_.handle(), &get, &chosen)) ? chosen
                                                                                      : VK_NULL_HANDLE;
}

VkResult OpenXrVulkanMaker::create_device(PFN_vkGetInstanceProcAddr get, VkPhysicalDevice physical,
                                          const VkDeviceCreateInfo& info, VkDevice* made) {
  auto create = openxr_info<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
  create.systemId = system_;
  create.pfnGetInstanceProcAddr = get;
  create.vulkanPhysicalDevice = physical;
  create.vulkanCreateInfo = &info;
  VkResult result = VK_ERROR_INITIALIZATION_FAILED;
  if (XR_FAILED(instance_.create_vulkan_device(instance_.handle(), &create, made, &result)))
    return VK_ERROR_INITIALIZATION_FAILED;
  return result;
}

Pose pose_from_openxr(const XrPosef& pose) {
  const Eigen::Quaterniond turn(pose.orientation.w, pose.orientation.x, pose.orientation.y,
                                pose.orientation.z);
  return {{pose.position.x, pose.position.y, pose.position.z}, turn.normalized()};
}

XrPosef openxr_from_pose(const Pose& pose) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const Eigen::Quaterniond& q = pose.orientation;
  return {{f(q.x()), f(q.y()), f(q.z()), f(q.w())},
          {f(pose.position_m.x()), f(pose.position_m.y()), f(pose.position_m.z())}};
}

}  // namespace livegs
