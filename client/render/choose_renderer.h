// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/splat_renderer.h"

namespace livegs {

enum class RendererChoice {
  Auto,    // Vulkan on a GPU; else the CPU, which is faster than a software Vulkan device
  Vulkan,  // Vulkan only, also on a software device
  Cpu,
};

// Creates a renderer and logs its name, and with Auto the reason for the CPU. Fails only if Vulkan was
// requested and is unavailable; the message has the remedy.
Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice);

// The same on a display's device, which may be a software device.
Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice,
                                                       std::shared_ptr<VulkanDevice> device);

// Returns `made`, the renderer of the named device, or, with Auto, a CPU renderer with a notice if it failed.
Result<std::unique_ptr<SplatRenderer>> made_or_cpu(RendererChoice choice, const std::string& device,
                                                   Result<std::unique_ptr<SplatRenderer>> made);

}  // namespace livegs
