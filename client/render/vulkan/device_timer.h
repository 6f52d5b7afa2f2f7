// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "compute/vulkan_commands.h"

namespace livegs {

// Passes that device time is attributed to.
enum class DevicePass : uint8_t { Skin, Project, Sort, Draw, Resolve, None };

// Timestamps between the passes of one picture, on the device's clock: pass times without the host's time
// between them. One picture at a time.
class DeviceTimer {
 public:
  DeviceTimer(VulkanCommands& commands, const VulkanHandles& handles)
      : commands_(commands), handles_(handles) {}
  ~DeviceTimer();
  DeviceTimer(const DeviceTimer&) = delete;
  DeviceTimer& operator=(const DeviceTimer&) = delete;

  // Begins a picture. Without a timer on the queue this and the functions below record nothing.
  Result<void> begin();
  // Records a timestamp after all previous commands: from here on time counts as `pass`. In a picture with
  // very many parts, skinning counts as projection from some part on, to reserve timestamps for later passes.
  Result<void> mark(DevicePass pass);
  // Milliseconds per pass, after all of them have run; false without a timer or if a timestamp is missing.
  bool read(std::array<double, 6>& ms_of_pass) const;

  static constexpr uint32_t kMaxTimestamps = 128;

 private:
  VulkanCommands& commands_;
  const VulkanHandles& handles_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
  std::array<DevicePass, kMaxTimestamps> passes_{};
  uint32_t marks_ = 0;
};

}  // namespace livegs
