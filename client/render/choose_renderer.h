// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/splat_renderer.h"

namespace livegs {

enum class RendererChoice {
  Auto,    // Vulkan on a GPU; else the CPU, which is faster than a Vulkan device in software
  Vulkan,  // Vulkan or nothing, in software too
  Cpu,
};

// Logs in one line what draws, and with Auto and no GPU, why it is the CPU. Fails only when Vulkan is asked
// for and cannot be had; the message has the remedy.
Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice);

// The same on a display's own device, in software too.
Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice,
                                                       std::shared_ptr<VulkanDevice> device);

// What was made of a device by its name; with Auto, where that failed, the CPU, whose notice says why.
Result<std::unique_ptr<SplatRenderer>> made_or_cpu(RendererChoice choice, const std::string& device,
                                                   Result<std::unique_ptr<SplatRenderer>> made);

}  // namespace livegs
