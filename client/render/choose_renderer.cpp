// SPDX-License-Identifier: Apache-2.0
#include "render/choose_renderer.h"

#include "core/log.h"

namespace livegs {
namespace {

Result<std::unique_ptr<SplatRenderer>> on_vulkan(bool software_too) {
  auto device = VulkanDevice::create();
  if (!device) return device.error();
  if (!software_too && (*device)->is_software()) {
    return Error{ErrorCode::Unavailable, "vulkan: " + (*device)->name() +
                                             " is software; --renderer vulkan draws with it all the same"};
  }
  return create_vulkan_renderer(*std::move(device));
}

}  // namespace

Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice) {
  if (choice != RendererChoice::Cpu) {
    auto vulkan = on_vulkan(choice == RendererChoice::Vulkan);
    if (vulkan) log_info("drawing with %s", (*vulkan)->name().c_str());
    if (vulkan || choice == RendererChoice::Vulkan) return vulkan;
    log_info("drawing with the cpu: %s", vulkan.error().message.c_str());
  }
  return Result<std::unique_ptr<SplatRenderer>>(create_cpu_renderer());
}

}  // namespace livegs
