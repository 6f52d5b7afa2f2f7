// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include "compute/vulkan_commands.h"

namespace livegs {

// What a picture's device time is spent on.
enum class DevicePass : uint8_t { Skin, Project, Sort, Draw, Resolve, None };

// Moments between the passes of one picture, on the device's own clock: what the passes take, without what
// the host does between them. One picture at a time.
class DeviceTimer {
 public:
  DeviceTimer(VulkanCommands& commands, const VulkanHandles& handles)
      : commands_(commands), handles_(handles) {}
  ~DeviceTimer();
  DeviceTimer(const DeviceTimer&) = delete;
  DeviceTimer& operator=(const DeviceTimer&) = delete;

  // Begins a picture. Where the queue has no clock nothing is recorded, here and below.
  Result<void> begin();
  // Records a moment, once all that was recorded before it is done: from here on it is `pass`. In a picture
  // of very many parts skinning is counted as projection from some part on: moments are kept for what
  // follows.
  Result<void> mark(DevicePass pass);
  // Milliseconds of each pass, once all of them have run; false where there is no clock or a moment is
  // missing.
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
