// SPDX-License-Identifier: Apache-2.0
#pragma once

#define XR_USE_GRAPHICS_API_VULKAN
#define VK_NO_PROTOTYPES
#include <vulkan/vulkan.h>
// After Vulkan's:
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <array>
#include <string>
#include <vector>

namespace livegs {

// An application of nothing but OpenXR's and Vulkan's own calls, none of them checked by a layer: it can call
// whatever is wrong. One action set with an action of each type for both hands, one swapchain, LOCAL.
class PlainApplication {
 public:
  PlainApplication() = default;
  ~PlainApplication();
  PlainApplication(const PlainApplication&) = delete;
  PlainApplication& operator=(const PlainApplication&) = delete;

  // As far as a session that is READY and has not begun; what is missing, or empty. "no Vulkan" is a reason
  // to skip.
  std::string open();
  // The next state change that is announced within a second; UNKNOWN without one.
  XrSessionState next_state();
  XrResult begin();
  // Whole frames with both views until this state is reached; false after a hundred.
  bool run_until(XrSessionState state);

  XrResult wait(XrFrameState& state) const;
  // Acquires, waits for and releases an image of the swapchain.
  bool take_image() const;
  // Of a right frame that shows the swapchain: what a test changes before it ends it.
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
