// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/device_timer.h"

#include "core/assert.h"

namespace livegs {
namespace {

constexpr uint32_t kReservedTimestamps = 16;  // timestamps reserved for the passes after projection

}  // namespace

DeviceTimer::~DeviceTimer() {
  if (pool_) handles_.vk.DestroyQueryPool(handles_.device, pool_, nullptr);
}

Result<void> DeviceTimer::begin() {
  marks_ = 0;
  if (handles_.timestamp_bits == 0) return {};
  if (!pool_) {
    auto info = vulkan_info<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = kMaxTimestamps;
    if (const VkResult made = handles_.vk.CreateQueryPool(handles_.device, &info, nullptr, &pool_);
        made != VK_SUCCESS)
      return vulkan_error("vkCreateQueryPool", made);
  }
  auto commands = commands_.record();
  if (!commands) return commands.error();
  handles_.vk.CmdResetQueryPool(*commands, pool_, 0, kMaxTimestamps);
  return {};
}

Result<void> DeviceTimer::mark(DevicePass pass) {
  if (!pool_) return {};
  if ((pass == DevicePass::Skin || pass == DevicePass::Project) &&
      marks_ + kReservedTimestamps > kMaxTimestamps)
    return {};
  LIVEGS_ASSERT(marks_ < kMaxTimestamps);
  auto commands = commands_.record();
  if (!commands) return commands.error();
  passes_[marks_] = pass;
  handles_.vk.CmdWriteTimestamp2(*commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, marks_++);
  return {};
}

bool DeviceTimer::read(std::array<double, 6>& ms_of_pass) const {
  std::array<uint64_t, kMaxTimestamps> moments{};
  if (!pool_ || marks_ < 2 ||
      handles_.vk.GetQueryPoolResults(handles_.device, pool_, 0, marks_, sizeof moments, moments.data(),
                                      sizeof(uint64_t), VK_QUERY_RESULT_64_BIT) != VK_SUCCESS)
    return false;
  const uint64_t bits =
      handles_.timestamp_bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << handles_.timestamp_bits) - 1;
  const double ms_a_step = 1e-6 * static_cast<double>(handles_.properties.limits.timestampPeriod);
  ms_of_pass.fill(0);
  for (uint32_t i = 1; i < marks_; ++i) {  // the counter may wrap around
    ms_of_pass[static_cast<size_t>(passes_[i - 1])] +=
        ms_a_step * static_cast<double>((moments[i] - moments[i - 1]) & bits);
  }
  return true;
}

}  // namespace livegs
