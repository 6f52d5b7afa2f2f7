// SPDX-License-Identifier: GPL-3.0-or-later
#include "gpu_report/device_facts.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <thread>

#include "common/compute/shift_words.h"
#include "compute/buffer.h"
#include "compute/vulkan_backend.h"
#include "compute/vulkan_commands.h"
#include "compute/vulkan_handles.h"
#include "core/percentile.h"
#include "core/text/format_text.h"

namespace livegs::gpu_report {
namespace {

// Buffers of a copy: larger than the last-level caches of today's GPUs (up to 256 MiB together with the
// second buffer), so that the copy runs at the speed of the memory. Halved while the device cannot bind them.
constexpr size_t kCopyBytes = size_t{1} << 30, kSoftwareCopyBytes = size_t{1} << 26;
constexpr int kCopies = 9, kWarmUpCopies = 3;

const char* kind_name(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
      return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
      return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
      return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
      return "software";
    default:
      return "other";
  }
}

std::string version_text(uint32_t version) {
  return format_text("%u.%u.%u", VK_API_VERSION_MAJOR(version), VK_API_VERSION_MINOR(version),
                     VK_API_VERSION_PATCH(version));
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("model name", 0) == 0 && line.find(": ") != std::string::npos)
      return line.substr(line.find(": ") + 2);
  }
  return "unknown";
}

// Two timestamps, with one copy by a pass between them. The copy command may use a slower engine: on an
// NVIDIA H200 it moves 410 GB/s of 4.3 TB/s.
class TimedCopy {
 public:
  explicit TimedCopy(const VulkanHandles& handles) : handles_(handles) {}
  ~TimedCopy() {
    if (pool_) handles_.vk.DestroyQueryPool(handles_.device, pool_, nullptr);
  }
  TimedCopy(const TimedCopy&) = delete;
  TimedCopy& operator=(const TimedCopy&) = delete;

  Result<double> seconds(Backend& backend, const Buffer& from, const Buffer& to) {
    if (!pool_) {
      auto info = vulkan_info<VkQueryPoolCreateInfo>(VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO);
      info.queryType = VK_QUERY_TYPE_TIMESTAMP;
      info.queryCount = 2;
      if (const VkResult made = handles_.vk.CreateQueryPool(handles_.device, &info, nullptr, &pool_);
          made != VK_SUCCESS)
        return vulkan_error("vkCreateQueryPool", made);
    }
    VulkanCommands& commands = *vulkan_commands(backend);
    auto begun = commands.record();  // after a barrier
    if (!begun) return begun.error();
    const VulkanFunctions& vk = handles_.vk;
    vk.CmdResetQueryPool(*begun, pool_, 0, 2);
    vk.CmdWriteTimestamp2(*begun, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, 0);
    if (auto done = dispatch_shift_words(backend, from.id(), to.id(),
                                         static_cast<uint32_t>(from.bytes() / sizeof(uint32_t)));
        !done)
      return done.error();
    auto copied = commands.record();
    if (!copied) return copied.error();
    vk.CmdWriteTimestamp2(*copied, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, pool_, 1);
    if (auto done = backend.submit(); !done) return done.error();
    std::array<uint64_t, 2> moments{};
    if (const VkResult read =
            vk.GetQueryPoolResults(handles_.device, pool_, 0, 2, sizeof moments, moments.data(),
                                   sizeof(uint64_t), VK_QUERY_RESULT_64_BIT);
        read != VK_SUCCESS)
      return vulkan_error("vkGetQueryPoolResults", read);
    const uint64_t bits =
        handles_.timestamp_bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << handles_.timestamp_bits) - 1;
    return 1e-9 * static_cast<double>(handles_.properties.limits.timestampPeriod) *
           static_cast<double>((moments[1] - moments[0]) & bits);
  }

 private:
  const VulkanHandles& handles_;
  VkQueryPool pool_ = VK_NULL_HANDLE;
};

Result<CopyBandwidth> copy_bandwidth(const VulkanDevice& device, Backend& backend, size_t bytes) {
  auto from = Buffer::create(backend, bytes);
  if (!from) return from.error();
  auto to = Buffer::create(backend, bytes);
  if (!to) return to.error();
  // Known contents: a driver may skip the copy of memory that was never written.
  const std::vector<std::byte> block(bytes, std::byte{0x5a});
  if (auto done = backend.upload(from->id(), block); !done) return done.error();
  TimedCopy copy(device.handles());
  std::vector<double> seconds;
  for (int i = -kWarmUpCopies; i < kCopies; ++i) {
    auto took = copy.seconds(backend, *from, *to);
    if (!took) return took.error();
    if (i >= 0) seconds.push_back(*took);
  }
  const double taken_s = percentile(seconds, 0.5);
  if (!(taken_s > 0))
    return Error{ErrorCode::Unavailable, device.name() + ": its clock reports no time for a copy"};
  return CopyBandwidth{2.0 * static_cast<double>(bytes) / taken_s, static_cast<double>(bytes)};
}

}  // namespace

DeviceFacts device_facts(const VulkanDevice& device) {
  const VulkanHandles& handles = device.handles();
  auto subgroup =
      vulkan_info<VkPhysicalDeviceSubgroupProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES);
  auto driver =
      vulkan_info<VkPhysicalDeviceDriverProperties>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES);
  driver.pNext = &subgroup;
  auto properties = vulkan_info<VkPhysicalDeviceProperties2>(VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2);
  properties.pNext = &driver;
  if (const auto read = reinterpret_cast<PFN_vkGetPhysicalDeviceProperties2>(
          handles.get(handles.instance, "vkGetPhysicalDeviceProperties2")))
    read(handles.physical_device, &properties);
  const VkPhysicalDeviceLimits& limits = handles.properties.limits;

  DeviceFacts facts;
  facts.name = device.name();
  facts.software = device.is_software();
  facts.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  facts.api_version = version_text(handles.properties.apiVersion);
  for (uint32_t heap = 0; heap < handles.memory.memoryHeapCount; ++heap) {
    if (handles.memory.memoryHeaps[heap].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      facts.memory_bytes += static_cast<double>(handles.memory.memoryHeaps[heap].size);
  }
  const auto add = [&](const char* property, const std::string& value) {
    facts.all.emplace_back(property, value);
  };
  const auto whole = [](uint64_t value) { return std::to_string(value); };
  add("name", facts.name);
  add("kind", kind_name(handles.properties.deviceType));
  add("vendor_id", format_text("0x%04x", handles.properties.vendorID));
  add("device_id", format_text("0x%04x", handles.properties.deviceID));
  add("driver", facts.driver);
  add("driver_version", format_text("0x%08x", handles.properties.driverVersion));
  add("api_version", facts.api_version);
  add("device_memory_bytes", format_text("%.0f", facts.memory_bytes));
  add("subgroup_size", whole(subgroup.subgroupSize));
  add("timestamp_period_ns", format_text("%g", static_cast<double>(limits.timestampPeriod)));
  add("timestamp_bits", whole(handles.timestamp_bits));
  add("max_storage_buffer_bytes", whole(limits.maxStorageBufferRange));
  add("max_storage_buffers_per_stage", whole(limits.maxPerStageDescriptorStorageBuffers));
  add("max_push_constants_bytes", whole(limits.maxPushConstantsSize));
  add("max_shared_memory_bytes", whole(limits.maxComputeSharedMemorySize));
  add("max_group_invocations", whole(limits.maxComputeWorkGroupInvocations));
  add("max_groups_x", whole(limits.maxComputeWorkGroupCount[0]));
  add("max_image_side_px", whole(limits.maxImageDimension2D));
  add("max_allocations", whole(limits.maxMemoryAllocationCount));
  add("processor", processor_name());
  add("processor_threads", whole(std::thread::hardware_concurrency()));
  return facts;
}

Result<CopyBandwidth> copy_bandwidth(const std::shared_ptr<VulkanDevice>& device) {
  if (device->handles().timestamp_bits == 0)
    return Error{ErrorCode::Unavailable, device->name() + ": has no clock"};
  auto backend = create_vulkan_backend(device);
  if (!backend) return backend.error();
  size_t bytes = std::min((*backend)->max_buffer_bytes() / 4 * 4,
                          device->is_software() ? kSoftwareCopyBytes : kCopyBytes);
  for (;; bytes /= 2) {
    auto measured = copy_bandwidth(*device, **backend, bytes);
    if (measured || measured.error().code != ErrorCode::TooLarge || bytes < 8) return measured;
  }
}

}  // namespace livegs::gpu_report
