// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/choose_device.h"

#include "compute/vulkan_backend.h"
#include "core/log.h"

namespace livegs {

void add_device_option(CLI::App& command, std::string& choice) {
  command
      .add_option(
          "--device", choice,
          "Device that draws pictures: auto (a GPU if there is one), cpu, or vulkan (also a software device)")
      ->check(CLI::IsMember({"auto", "cpu", "vulkan"}))
      ->type_name("DEVICE")
      ->capture_default_str();
}

Result<std::unique_ptr<Backend>> choose_device(const std::string& choice) {
  if (choice == "cpu") return std::unique_ptr<Backend>();
  VulkanDeviceOptions options;
  options.pipeline_cache_folder = user_pipeline_cache_folder();
  auto device = VulkanDevice::create(options);
  if (!device && choice == "vulkan") return device.error();
  if (!device || (choice == "auto" && (*device)->is_software())) return std::unique_ptr<Backend>();
  const std::string name = (*device)->name();
  auto backend = create_vulkan_backend(*std::move(device));
  if (!backend && choice == "auto") {
    log_warn("device: %s: %s; the CPU is used", name.c_str(), backend.error().message.c_str());
    return std::unique_ptr<Backend>();
  }
  if (backend) log_info("device: %s", name.c_str());
  return backend;
}

}  // namespace livegs
