// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "compute/vulkan_memory.h"
#include "xr/display/text_layer.h"
#include "xr/openxr/openxr_instance.h"
#include "xr/openxr/openxr_swapchain.h"

namespace livegs {

// Text that is fixed to the view: a quad in VIEW space, slightly below the centre. One thread.
class OpenXrTextLayer {
 public:
  explicit OpenXrTextLayer(const VulkanHandles& handles) : handles_(handles) {}
  ~OpenXrTextLayer() { end(); }
  OpenXrTextLayer(const OpenXrTextLayer&) = delete;
  OpenXrTextLayer& operator=(const OpenXrTextLayer&) = delete;

  void set(const std::string& text) { text_ = text; }
  void end();  // call before the session is destroyed
  // The layer for xrEndFrame, empty without text; valid until the next call.
  XrResult layer(XrSession session, std::optional<XrCompositionLayerQuad>& layer);

 private:
  XrResult write(XrSession session);

  const VulkanHandles& handles_;
  const TextPlate plate_;
  std::string text_, written_;
  // Session state.
  XrSpace view_ = XR_NULL_HANDLE;
  std::optional<OpenXrSwapchain> swapchain_;
  int height_px_ = 0;
};

}  // namespace livegs
