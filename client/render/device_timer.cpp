// SPDX-License-Identifier: Apache-2.0
#include "render/device_timer.h"

#include <array>

#include "core/assert.h"

namespace livegs {

DeviceTimer::~DeviceTimer() {
  if (pool_) handles_.vk.DestroyQueryPool(handles_.device, pool_, nullptr);
}

Result<void> DeviceTimer::begin() {
  marks_ = 0;
  if (handles_.timestamp_bits == 0) return {};
  if (!pool_) {
    auto info = vulkan_info<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = kMost;
    if (const VkResult made = handles_.vk.CreateQueryPool(handles_.device, &info, nullptr, &pool_); made != VK_SUCCESS)
      return vulkan_error("vkCreateQueryPool", made);
  }
  auto commands = commands_.record();
  if (!commands) return commands.error();
  handles_.vk.CmdResetQueryPool(*commands, pool_, 0, kMost);
  return {};
}

Result<void> DeviceTimer::mark() {
  if (!pool_) return {};
  LIVEGS_ASSERT(marks_ < kMost);
  auto commands = commands_.record();
  if (!commands) return commands.error();
  handles_.vk.CmdWriteTimestamp2(*commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, marks_++);
  return {};
}

std::vector<double> DeviceTimer::spans_ms() const {
  std::array<uint64_t, kMost> moments{};
  if (!pool_ || marks_ < 2 ||
      handles_.vk.GetQueryPoolResults(handles_.device, pool_, 0, marks_, sizeof moments, moments.data(), sizeof(uint64_t),
                                      VK_QUERY_RESULT_64_BIT) != VK_SUCCESS)
    return {};
  const uint64_t bits = handles_.timestamp_bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << handles_.timestamp_bits) - 1;
  const double ms_a_step = 1e-6 * static_cast<double>(handles_.properties.limits.timestampPeriod);
  std::vector<double> spans;
  for (uint32_t i = 1; i < marks_; ++i)  // the clock may run over
    spans.push_back(ms_a_step * static_cast<double>((moments[i] - moments[i - 1]) & bits));
  return spans;
}

}  // namespace livegs
