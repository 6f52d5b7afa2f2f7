// SPDX-License-Identifier: Apache-2.0
#pragma once

#define XR_USE_GRAPHICS_API_VULKAN
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>
// Must follow the Vulkan header.
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <array>
#include <string>
#include <vector>

namespace livegs {

// A minimal application that uses OpenXR and Vulkan directly, without validation layers, so that tests can
// make invalid calls. It has one action set with an action of each type for both hands, one swapchain, and a
// LOCAL space.
class PlainApplication {
 public:
  PlainApplication() = default;
  ~PlainApplication();
  PlainApplication(const PlainApplication&) = delete;
  PlainApplication& operator=(const PlainApplication&) = delete;

  // Opens everything up to a session in state READY that has not begun. Returns the step that failed, or an
  // empty string. "no Vulkan" is a reason to skip the test.
  std::string open();
  // Waits up to one second for the next state change. Returns UNKNOWN if there is none.
  XrSessionState next_state();
  XrResult begin();
  // Runs complete frames with both views until the state is reached. Returns false after 100 frames.
  bool run_until(XrSessionState state);

  XrResult wait(XrFrameState& state) const;
  // Acquires, waits for and releases an image of the swapchain.
  bool take_image() const;
  // The arguments of xrEndFrame for a valid frame that shows the swapchain. Tests modify them.
  struct Ending {
    std::array<XrCompositionLayerProjectionView, 2> views;
    XrCompositionLayerProjection layer;
    std::vector<const XrCompositionLayerBaseHeader*> layers;
    XrFrameEndInfo info;
  };
  void fill(Ending& ending, XrTime displayed) const;
  XrPath path(const char* text) const;

  XrInstance instance = XR_NULL_HANDLE;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  XrSession session = XR_NULL_HANDLE;
  XrSpace local = XR_NULL_HANDLE;
  XrSwapchain swapchain = XR_NULL_HANDLE;
  XrSwapchainCreateInfo swapchain_info{};
  XrActionSet set = XR_NULL_HANDLE;
  XrAction grip = XR_NULL_HANDLE, pull = XR_NULL_HANDLE, shoot = XR_NULL_HANDLE, feel = XR_NULL_HANDLE;

 private:
  std::string open_vulkan();
  std::string open_session();
  VkInstance vulkan_ = VK_NULL_HANDLE;
  VkPhysicalDevice physical_ = VK_NULL_HANDLE;
  VkDevice device_ = VK_NULL_HANDLE;
  PFN_vkGetInstanceProcAddr get_ = nullptr;
};

template <class T>
T openxr(XrStructureType type) {
  T made{};
  made.type = type;
  return made;
}

}  // namespace livegs
