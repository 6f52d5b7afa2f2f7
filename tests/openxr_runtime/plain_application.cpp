// SPDX-License-Identifier: Apache-2.0
#include "openxr_runtime/plain_application.h"

#include <dlfcn.h>

#include <chrono>
#include <cstdio>
#include <thread>
#include <tuple>

namespace livegs {
namespace {

constexpr uint32_t kSize = 32;

template <class Function>
Function call(XrInstance instance, const char* name) {
  PFN_xrVoidFunction function = nullptr;
  xrGetInstanceProcAddr(instance, name, &function);
  return reinterpret_cast<Function>(function);
}

XrPosef nowhere() { return {{0, 0, 0, 1}, {0, 0, 0}}; }

}  // namespace

PlainApplication::~PlainApplication() {
  if (swapchain) xrDestroySwapchain(swapchain);
  if (local) xrDestroySpace(local);
  if (session) xrDestroySession(session);
  if (set) xrDestroyActionSet(set);
  if (device_) reinterpret_cast<PFN_vkDestroyDevice>(get_(vulkan_, "vkDestroyDevice"))(device_, nullptr);
  if (vulkan_) reinterpret_cast<PFN_vkDestroyInstance>(get_(vulkan_, "vkDestroyInstance"))(vulkan_, nullptr);
  if (instance) xrDestroyInstance(instance);
}

XrPath PlainApplication::path(const char* text) const {
  XrPath made = XR_NULL_PATH;
  xrStringToPath(instance, text, &made);
  return made;
}

std::string PlainApplication::open_vulkan() {
  static void* const library = dlopen("libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!library) return "no Vulkan";
  get_ = reinterpret_cast<PFN_vkGetInstanceProcAddr>(dlsym(library, "vkGetInstanceProcAddr"));
  auto asked = openxr<XrGraphicsRequirementsVulkanKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_VULKAN_KHR);
  if (call<PFN_xrGetVulkanGraphicsRequirements2KHR>(instance, "xrGetVulkanGraphicsRequirements2KHR")(
          instance, system, &asked) != XR_SUCCESS)
    return "xrGetVulkanGraphicsRequirements2KHR";
  VkApplicationInfo application{
      VK_STRUCTURE_TYPE_APPLICATION_INFO, nullptr, "test", 1, "test", 1, VK_API_VERSION_1_1};
  VkInstanceCreateInfo vulkan{};
  vulkan.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  vulkan.pApplicationInfo = &application;
  auto create = openxr<XrVulkanInstanceCreateInfoKHR>(XR_TYPE_VULKAN_INSTANCE_CREATE_INFO_KHR);
  create.systemId = system;
  create.pfnGetInstanceProcAddr = get_;
  create.vulkanCreateInfo = &vulkan;
  VkResult result = VK_SUCCESS;
  if (call<PFN_xrCreateVulkanInstanceKHR>(instance, "xrCreateVulkanInstanceKHR")(instance, &create, &vulkan_,
                                                                                 &result) != XR_SUCCESS)
    return "xrCreateVulkanInstanceKHR";
  if (result != VK_SUCCESS) return "no Vulkan";
  auto which = openxr<XrVulkanGraphicsDeviceGetInfoKHR>(XR_TYPE_VULKAN_GRAPHICS_DEVICE_GET_INFO_KHR);
  which.systemId = system;
  which.vulkanInstance = vulkan_;
  if (call<PFN_xrGetVulkanGraphicsDevice2KHR>(instance, "xrGetVulkanGraphicsDevice2KHR")(
          instance, &which, &physical_) != XR_SUCCESS)
    return "no Vulkan";
  const float priority = 1;
  VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
  VkDeviceCreateInfo device{};
  device.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  device.queueCreateInfoCount = 1;
  device.pQueueCreateInfos = &queue;
  auto make = openxr<XrVulkanDeviceCreateInfoKHR>(XR_TYPE_VULKAN_DEVICE_CREATE_INFO_KHR);
  make.systemId = system;
  make.pfnGetInstanceProcAddr = get_;
  make.vulkanPhysicalDevice = physical_;
  make.vulkanCreateInfo = &device;
  if (call<PFN_xrCreateVulkanDeviceKHR>(instance, "xrCreateVulkanDeviceKHR")(instance, &make, &device_,
                                                                             &result) != XR_SUCCESS ||
      result != VK_SUCCESS)
    return "xrCreateVulkanDeviceKHR";
  return "";
}

std::string PlainApplication::open_session() {
  auto binding = openxr<XrGraphicsBindingVulkan2KHR>(XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR);
  binding.instance = vulkan_;
  binding.physicalDevice = physical_;
  binding.device = device_;
  auto info = openxr<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  info.next = &binding;
  info.systemId = system;
  if (xrCreateSession(instance, &info, &session) != XR_SUCCESS) return "xrCreateSession";
  auto space = openxr<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  space.poseInReferenceSpace = nowhere();
  if (xrCreateReferenceSpace(session, &space, &local) != XR_SUCCESS) return "xrCreateReferenceSpace";
  swapchain_info = openxr<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
  swapchain_info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
  swapchain_info.format = VK_FORMAT_R8G8B8A8_SRGB;
  swapchain_info.width = swapchain_info.height = kSize;
  swapchain_info.sampleCount = swapchain_info.faceCount = swapchain_info.mipCount = 1;
  swapchain_info.arraySize = 2;
  return xrCreateSwapchain(session, &swapchain_info, &swapchain) == XR_SUCCESS ? "" : "xrCreateSwapchain";
}

std::string PlainApplication::open() {
  auto info = openxr<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::snprintf(info.applicationInfo.applicationName, XR_MAX_APPLICATION_NAME_SIZE, "test");
  info.applicationInfo.apiVersion = XR_CURRENT_API_VERSION;
  const char* vulkan = XR_KHR_VULKAN_ENABLE2_EXTENSION_NAME;
  info.enabledExtensionCount = 1;
  info.enabledExtensionNames = &vulkan;
  if (xrCreateInstance(&info, &instance) != XR_SUCCESS) return "xrCreateInstance";
  auto get = openxr<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  get.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  if (xrGetSystem(instance, &get, &system) != XR_SUCCESS) return "xrGetSystem";
  if (const std::string missing = open_vulkan(); !missing.empty()) return missing;
  auto set_info = openxr<XrActionSetCreateInfo>(XR_TYPE_ACTION_SET_CREATE_INFO);
  std::snprintf(set_info.actionSetName, XR_MAX_ACTION_SET_NAME_SIZE, "hands");
  std::snprintf(set_info.localizedActionSetName, XR_MAX_LOCALIZED_ACTION_SET_NAME_SIZE, "Hands");
  if (xrCreateActionSet(instance, &set_info, &set) != XR_SUCCESS) return "xrCreateActionSet";
  const std::array hands{path("/user/hand/left"), path("/user/hand/right")};
  std::vector<XrActionSuggestedBinding> bindings;
  for (const auto& [action, type, name, bound] :
       {std::tuple(&grip, XR_ACTION_TYPE_POSE_INPUT, "grip", "/user/hand/right/input/grip/pose"),
        {&pull, XR_ACTION_TYPE_FLOAT_INPUT, "pull", "/user/hand/right/input/trigger/value"},
        {&shoot, XR_ACTION_TYPE_BOOLEAN_INPUT, "shoot", "/user/hand/right/input/a/click"},
        {&feel, XR_ACTION_TYPE_VIBRATION_OUTPUT, "feel", "/user/hand/right/output/haptic"}}) {
    auto action_info = openxr<XrActionCreateInfo>(XR_TYPE_ACTION_CREATE_INFO);
    action_info.actionType = type;
    std::snprintf(action_info.actionName, XR_MAX_ACTION_NAME_SIZE, "%s", name);
    std::snprintf(action_info.localizedActionName, XR_MAX_LOCALIZED_ACTION_NAME_SIZE, "%s", name);
    action_info.countSubactionPaths = hands.size();
    action_info.subactionPaths = hands.data();
    if (xrCreateAction(set, &action_info, action) != XR_SUCCESS) return std::string("xrCreateAction ") + name;
    bindings.push_back({*action, path(bound)});
  }
  auto suggested =
      openxr<XrInteractionProfileSuggestedBinding>(XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING);
  suggested.interactionProfile = path("/interaction_profiles/oculus/touch_controller");
  suggested.countSuggestedBindings = static_cast<uint32_t>(bindings.size());
  suggested.suggestedBindings = bindings.data();
  if (xrSuggestInteractionProfileBindings(instance, &suggested) != XR_SUCCESS)
    return "xrSuggestInteractionProfileBindings";
  if (const std::string missing = open_session(); !missing.empty()) return missing;
  for (const XrSessionState wanted : {XR_SESSION_STATE_IDLE, XR_SESSION_STATE_READY}) {
    if (next_state() != wanted) return "the session did not become ready";
  }
  return "";
}

XrSessionState PlainApplication::next_state() {
  for (int tries = 0; tries < 100; ++tries) {
    auto event = openxr<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    const XrResult polled = xrPollEvent(instance, &event);
    if (polled == XR_SUCCESS && event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED)
      return reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state;
    if (polled != XR_SUCCESS) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return XR_SESSION_STATE_UNKNOWN;
}

XrResult PlainApplication::begin() {
  auto info = openxr<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
  info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  return xrBeginSession(session, &info);
}

XrResult PlainApplication::wait(XrFrameState& state) const {
  state = openxr<XrFrameState>(XR_TYPE_FRAME_STATE);
  return xrWaitFrame(session, nullptr, &state);
}

bool PlainApplication::take_image() const {
  uint32_t index = 0;
  auto wait = openxr<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  wait.timeout = XR_INFINITE_DURATION;
  return xrAcquireSwapchainImage(swapchain, nullptr, &index) == XR_SUCCESS &&
         xrWaitSwapchainImage(swapchain, &wait) == XR_SUCCESS &&
         xrReleaseSwapchainImage(swapchain, nullptr) == XR_SUCCESS;
}

void PlainApplication::fill(Ending& ending, XrTime displayed) const {
  for (uint32_t eye = 0; eye < 2; ++eye) {
    ending.views[eye] = openxr<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
    ending.views[eye].pose = nowhere();
    ending.views[eye].fov = {-0.8f, 0.8f, 0.8f, -0.8f};
    ending.views[eye].subImage = {swapchain, {{0, 0}, {kSize, kSize}}, eye};
  }
  ending.layer = openxr<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
  ending.layer.space = local;
  ending.layer.viewCount = 2;
  ending.layer.views = ending.views.data();
  ending.layers = {reinterpret_cast<const XrCompositionLayerBaseHeader*>(&ending.layer)};
  ending.info = openxr<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  ending.info.displayTime = displayed;
  ending.info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  ending.info.layerCount = 1;
  ending.info.layers = ending.layers.data();
}

bool PlainApplication::run_until(XrSessionState wanted) {
  for (int frame = 0; frame < 100; ++frame) {
    auto event = openxr<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    while (xrPollEvent(instance, &event) == XR_SUCCESS) {
      if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED &&
          reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state == wanted)
        return true;
      event = openxr<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    }
    XrFrameState state;
    Ending ending;
    if (wait(state) != XR_SUCCESS || xrBeginFrame(session, nullptr) != XR_SUCCESS || !take_image())
      return false;
    fill(ending, state.predictedDisplayTime);
    if (xrEndFrame(session, &ending.info) != XR_SUCCESS) return false;
  }
  return false;
}

}  // namespace livegs
