// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "core/result.h"

namespace livegs {

struct VulkanHandles;
class VulkanMaker;

struct VulkanDeviceOptions {
  // Loads the Khronos validation layer with synchronization checks. Same as LIVEGS_VULKAN_VALIDATION=1 in the
  // environment.
  bool validation = false;
  // Called for each warning and error of the layer, on any thread, until the device is destroyed. Default:
  // log_warn.
  std::function<void(const std::string& message)> on_validation_message;
  // Limit of device memory for kernels and images, bytes; 0: the memory of the device. Same as
  // LIVEGS_VULKAN_MEMORY_MB in the environment.
  size_t memory_limit_bytes = 0;
  // Creates and chooses the device during create(); null: Vulkan itself.
  VulkanMaker* maker = nullptr;
  // Folder of compiled pipelines between runs (pipeline_cache.h): read by create(), written when the device
  // is destroyed. Empty: pipelines are not saved.
  std::filesystem::path pipeline_cache_folder;
};

// LIVEGS_PIPELINE_CACHE in the environment, otherwise the user's cache folder (user_cache.h). Empty if there
// is neither.
std::filesystem::path user_pipeline_cache_folder();

// A Vulkan 1.3 device with one queue for compute and, if supported, graphics. The loader is opened at first
// use, so programs start on machines without Vulkan.
class VulkanDevice {
 public:
  // Selects a device in this order: discrete, integrated, virtual, software such as lavapipe. The first of
  // equal devices is selected. Errors, Unavailable with the remedy: the loader or a requested validation
  // layer is missing, or no device has Vulkan 1.3 and the limits of pass.h.
  static Result<std::shared_ptr<VulkanDevice>> create(const VulkanDeviceOptions& options = {});

  ~VulkanDevice();
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  bool can_draw() const;
  bool is_software() const;         // for example lavapipe
  const std::string& name() const;  // as reported by the driver: "llvmpipe (LLVM 15.0.6, 256 bits)"

  // For this room, client/render and client/xr.
  const VulkanHandles& handles() const { return *handles_; }

 private:
  explicit VulkanDevice(std::unique_ptr<VulkanHandles> handles);
  std::unique_ptr<VulkanHandles> handles_;
};

}  // namespace livegs
