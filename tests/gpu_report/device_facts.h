// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "compute/vulkan_device.h"

namespace livegs::gpu_report {

struct DeviceFacts {
  std::string name, driver, api_version;
  double memory_bytes = 0;  // device-local heaps together
  bool software = false;
  std::vector<std::pair<std::string, std::string>> all;  // property and value, for device.csv
};

DeviceFacts device_facts(const VulkanDevice& device);

// Bytes per second of a pass that copies a buffer, by the device's clock, reads and writes together: median
// of several copies.
struct CopyBandwidth {
  double bytes_s = 0;
  double buffer_bytes = 0;  // size of a copied buffer
};
// Unavailable if the device has no clock.
Result<CopyBandwidth> copy_bandwidth(const std::shared_ptr<VulkanDevice>& device);

}  // namespace livegs::gpu_report
