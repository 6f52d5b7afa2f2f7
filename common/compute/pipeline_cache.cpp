// SPDX-License-Identifier: Apache-2.0
#include "compute/pipeline_cache.h"

#include <algorithm>
#include <cstring>

#include "core/content_hash.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text/format_text.h"

namespace livegs {
namespace {

constexpr uint64_t kMaxCacheBytes = uint64_t{256} << 20;
constexpr uint32_t kVersion = 1;

struct FileHeader {
  char magic[4] = {'L', 'G', 'P', 'C'};
  uint32_t version = kVersion;
  uint32_t driver_version = 0;
  char data_hash[64] = {};
};
static_assert(sizeof(FileHeader) == 76);

Error not_usable(const char* why) { return invalid_data(std::string("pipeline cache: ") + why); }

// Whether the driver data, laid out as by vkGetPipelineCacheData, belong to this device.
bool is_of(const VkPhysicalDeviceProperties& device, std::span<const std::byte> data) {
  VkPipelineCacheHeaderVersionOne header;
  if (data.size() < sizeof header) return false;
  std::memcpy(&header, data.data(), sizeof header);
  return header.headerSize >= sizeof header && header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
         header.vendorID == device.vendorID && header.deviceID == device.deviceID &&
         std::memcmp(header.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE) == 0;
}

Result<std::vector<std::byte>> read_data(const VulkanHandles& handles) {
  if (std::error_code ignored; !std::filesystem::exists(handles.pipeline_cache_file, ignored))
    return std::vector<std::byte>();
  const auto file = read_file(handles.pipeline_cache_file, kMaxCacheBytes);
  if (!file) return file.error();
  auto data = decode_pipeline_cache(handles.properties, *file);
  if (!data)
    return Error{data.error().code, handles.pipeline_cache_file.string() + ": " + data.error().message};
  return data;
}

}  // namespace

std::filesystem::path pipeline_cache_file(const std::filesystem::path& folder,
                                          const VkPhysicalDeviceProperties& device) {
  return folder / format_text("%04x-%04x.pipelines", device.vendorID, device.deviceID);
}

std::vector<std::byte> encode_pipeline_cache(const VkPhysicalDeviceProperties& device,
                                             std::span<const std::byte> data) {
  FileHeader header;
  header.driver_version = device.driverVersion;
  content_hash(data).copy(header.data_hash, sizeof header.data_hash);
  std::vector<std::byte> file(sizeof header + data.size());
  std::memcpy(file.data(), &header, sizeof header);
  std::copy(data.begin(), data.end(), file.begin() + sizeof header);
  return file;
}

Result<std::vector<std::byte>> decode_pipeline_cache(const VkPhysicalDeviceProperties& device,
                                                     std::span<const std::byte> file) {
  FileHeader header;
  const FileHeader expected;
  if (file.size() < sizeof header) return not_usable("the file is truncated");
  std::memcpy(&header, file.data(), sizeof header);
  const auto data = file.subspan(sizeof header);
  if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 || header.version != kVersion)
    return not_usable("the file has an unknown format");
  if (header.driver_version != device.driverVersion)
    return not_usable("the file is from another driver version");
  if (content_hash(data) != std::string_view(header.data_hash, sizeof header.data_hash))
    return not_usable("the file is damaged");
  if (!is_of(device, data)) return not_usable("the file is from another device");
  return std::vector<std::byte>(data.begin(), data.end());
}

Result<void> create_pipeline_cache(VulkanHandles& handles, const std::filesystem::path& folder) {
  std::vector<std::byte> data;
  if (!folder.empty()) {
    handles.pipeline_cache_file = pipeline_cache_file(folder, handles.properties);
    auto read = read_data(handles);
    if (read)
      data = *std::move(read);
    else
      log_debug("%s; pipelines will be compiled again", read.error().message.c_str());
  }
  auto info = vulkan_info<VkPipelineCacheCreateInfo>(VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO);
  info.initialDataSize = data.size();
  info.pInitialData = data.data();
  if (const VkResult made =
          handles.vk.CreatePipelineCache(handles.device, &info, nullptr, &handles.pipeline_cache);
      made != VK_SUCCESS) {
    handles.pipeline_cache = VK_NULL_HANDLE;
    return vulkan_error("vkCreatePipelineCache", made);
  }
  if (!data.empty()) handles.pipeline_cache_hash = content_hash(data);
  return {};
}

void save_pipeline_cache(const VulkanHandles& handles) {
  if (handles.pipeline_cache_file.empty() || !handles.pipeline_cache) return;
  size_t bytes = 0;
  std::vector<std::byte> data;
  if (handles.vk.GetPipelineCacheData(handles.device, handles.pipeline_cache, &bytes, nullptr) != VK_SUCCESS)
    return;
  data.resize(bytes);
  if (handles.vk.GetPipelineCacheData(handles.device, handles.pipeline_cache, &bytes, data.data()) !=
      VK_SUCCESS)
    return;
  data.resize(bytes);
  if (content_hash(data) == handles.pipeline_cache_hash) return;
  std::error_code ignored;
  std::filesystem::create_directories(handles.pipeline_cache_file.parent_path(), ignored);
  const auto written =
      write_file_atomically(handles.pipeline_cache_file, encode_pipeline_cache(handles.properties, data));
  if (!written)
    log_debug("pipeline cache: %s; pipelines will be compiled again at the next start",
              written.error().message.c_str());
}

}  // namespace livegs
