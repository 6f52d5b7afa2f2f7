// SPDX-License-Identifier: Apache-2.0
#pragma once

// For the .cpp files of this room and its tests only: it exposes Vulkan types.

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "compute/vulkan_handles.h"

namespace livegs {

// The compiled pipelines of one device, kept in a file between runs. A file is a 76-byte header and the
// driver's data:
//   "LGPC", version 1, driver version (uint32 each), SHA-256 of the data as 64 hexadecimal digits.
// The data start with Vulkan's header of vendor, device and pipelineCacheUUID. The additional header is
// needed because drivers may crash on damaged data and often ignore their own version (Kapoulkine 2019,
// Creating a robust pipeline cache with Vulkan).

// FOLDER/VENDOR-DEVICE.pipelines, in hexadecimal.
std::filesystem::path pipeline_cache_file(const std::filesystem::path& folder,
                                          const VkPhysicalDeviceProperties& device);

std::vector<std::byte> encode_pipeline_cache(const VkPhysicalDeviceProperties& device,
                                             std::span<const std::byte> data);
// Returns the driver data. InvalidData if they are damaged or from another device or driver version.
Result<std::vector<std::byte>> decode_pipeline_cache(const VkPhysicalDeviceProperties& device,
                                                     std::span<const std::byte> file);

// Creates handles.pipeline_cache, filled from the device's file in `folder`. An unusable file is ignored and
// logged at debug level. An empty `folder`: no file.
Result<void> create_pipeline_cache(VulkanHandles& handles, const std::filesystem::path& folder);
// Writes the file atomically, if its content has changed. A failure is logged at debug level.
void save_pipeline_cache(const VulkanHandles& handles);

}  // namespace livegs
