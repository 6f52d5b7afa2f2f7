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
  // Loads the Khronos validation layer with synchronization checks; LIVEGS_VULKAN_VALIDATION=1 in the
  // environment does the same.
  bool validation = false;
  // Receives each warning and error of the layer, on any thread, until the device is destroyed. Default:
  // log_warn.
  std::function<void(const std::string& message)> on_validation_message;
  // Of device memory for kernels and pictures, as if the device had no more; 0: what it has.
  // LIVEGS_VULKAN_MEMORY_MB in the environment does the same.
  size_t memory_limit_bytes = 0;
  // Makes the device in Vulkan's place and says which, during create(); null: Vulkan does.
  VulkanMaker* maker = nullptr;
  // Folder in which compiled pipelines are kept between runs (pipeline_cache.h): read by create(), written
  // when the device is destroyed. Empty: they are not kept.
  std::filesystem::path pipeline_cache_folder;
};

// LIVEGS_PIPELINE_CACHE in the environment, else the user's cache folder (user_cache.h). Empty when there is
// neither.
std::filesystem::path user_pipeline_cache_folder();

// A Vulkan 1.3 device with one queue that can compute, and draw where the device can at all. The loader is
// opened when it is first needed, so programs start on machines without Vulkan.
class VulkanDevice {
 public:
  // Takes the best device there is: discrete, integrated, virtual, then software such as lavapipe; of equals
  // the first. Unavailable, with the remedy, when there is no loader, no validation layer though asked for,
  // or no device of Vulkan 1.3 with the limits of pass.h.
  static Result<std::shared_ptr<VulkanDevice>> create(const VulkanDeviceOptions& options = {});

  ~VulkanDevice();
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  bool can_draw() const;
  bool is_software() const;         // lavapipe is
  const std::string& name() const;  // as the driver tells it: "llvmpipe (LLVM 15.0.6, 256 bits)"

  // For this room, client/render and client/xr.
  const VulkanHandles& handles() const { return *handles_; }

 private:
  explicit VulkanDevice(std::unique_ptr<VulkanHandles> handles);
  std::unique_ptr<VulkanHandles> handles_;
};

}  // namespace livegs
