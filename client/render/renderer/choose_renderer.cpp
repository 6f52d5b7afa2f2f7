// SPDX-License-Identifier: Apache-2.0
#include "render/choose_renderer.h"

#include "core/log.h"

namespace livegs {

Result<std::unique_ptr<SplatRenderer>> made_or_cpu(RendererChoice choice, const std::string& device,
                                                   Result<std::unique_ptr<SplatRenderer>> made) {
  if (!made && choice == RendererChoice::Auto) {
    auto cpu = create_cpu_renderer_instead_of(device, made.error());
    log_warn("%s", cpu->notice().c_str());
    return Result<std::unique_ptr<SplatRenderer>>(std::move(cpu));
  }
  if (made) log_info("renderer: %s", (*made)->name().c_str());
  return made;
}

Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice,
                                                       std::shared_ptr<VulkanDevice> device) {
  if (choice == RendererChoice::Cpu) return Result<std::unique_ptr<SplatRenderer>>(create_cpu_renderer());
  const std::string name = "vulkan: " + device->name();
  return made_or_cpu(choice, name, create_vulkan_renderer(std::move(device)));
}

Result<std::unique_ptr<SplatRenderer>> choose_renderer(RendererChoice choice) {
  if (choice == RendererChoice::Cpu) return Result<std::unique_ptr<SplatRenderer>>(create_cpu_renderer());
  VulkanDeviceOptions options;
  options.pipeline_cache_folder = user_pipeline_cache_folder();
  auto device = VulkanDevice::create(options);
  if (!device && choice == RendererChoice::Vulkan) return device.error();
  // A missing GPU is not reported; a GPU that ran out of memory is.
  if (!device && device.error().code == ErrorCode::TooLarge)
    return made_or_cpu(choice, "vulkan", device.error());
  if (choice == RendererChoice::Auto && (!device || (*device)->is_software())) {
    const std::string why = !device ? device.error().message
                                    : "vulkan: no GPU, only the software driver " + (*device)->name() +
                                          "; force it with --renderer vulkan";
    log_info("renderer: cpu: %s", why.c_str());
    return Result<std::unique_ptr<SplatRenderer>>(create_cpu_renderer());
  }
  return choose_renderer(choice, *std::move(device));
}

}  // namespace livegs
