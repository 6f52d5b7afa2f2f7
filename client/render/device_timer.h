// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "compute/vulkan_commands.h"

namespace livegs {

// Moments between the passes of one picture, on the device's own clock: what the passes take, without what the host
// does between them. One picture at a time.
class DeviceTimer {
 public:
  DeviceTimer(VulkanCommands& commands, const VulkanHandles& handles) : commands_(commands), handles_(handles) {}
  ~DeviceTimer();
  DeviceTimer(const DeviceTimer&) = delete;
  DeviceTimer& operator=(const DeviceTimer&) = delete;

  // Begins a picture. Where the queue has no clock nothing is recorded, here and below.
  Result<void> begin();
  // Records a moment: all that was recorded before it is done then. kMost at most.
  Result<void> mark();
  // Milliseconds from each moment to the next, once all of them have run; empty where there is no clock.
  std::vector<double> spans_ms() const;

  static constexpr uint32_t kMost = 8;

 private:
  VulkanCommands& commands_;
  const VulkanHandles& handles_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  uint32_t marks_ = 0;
};

}  // namespace livegs
