// SPDX-License-Identifier: Apache-2.0
#include "compute/pipeline_cache.h"

#include <array>
#include <cstring>

#include "common/compute/shared_vulkan.h"
#include "common/compute/shift_words.h"
#include "compute/buffer.h"
#include "core/file.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

VkPhysicalDeviceProperties some_device() {
  VkPhysicalDeviceProperties device{};
  device.vendorID = 0x10de;
  device.deviceID = 0x2330;
  device.driverVersion = 7;
  for (uint8_t i = 0; i < VK_UUID_SIZE; ++i) device.pipelineCacheUUID[i] = i;
  return device;
}

// Vulkan's header and a few bytes of driver data.
std::vector<std::byte> data_of(const VkPhysicalDeviceProperties& device) {
  VkPipelineCacheHeaderVersionOne header{
      sizeof header, VK_PIPELINE_CACHE_HEADER_VERSION_ONE, device.vendorID, device.deviceID, {}};
  std::memcpy(header.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE);
  std::vector<std::byte> data(sizeof header + 20, std::byte{42});
  std::memcpy(data.data(), &header, sizeof header);
  return data;
}

ErrorCode code_of(const VkPhysicalDeviceProperties& device, std::span<const std::byte> file) {
  const auto read = decode_pipeline_cache(device, file);
  return read ? ErrorCode::Internal : read.error().code;
}

TEST(PipelineCache, RoundTripsThroughAFile) {
  const auto device = some_device();
  const auto read = decode_pipeline_cache(device, encode_pipeline_cache(device, data_of(device)));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, data_of(device));
  EXPECT_EQ(pipeline_cache_file("/cache", device), "/cache/10de-2330.pipelines");
}

TEST(PipelineCache, RejectsDamagedFiles) {
  const auto device = some_device();
  const auto file = encode_pipeline_cache(device, data_of(device));
  for (size_t bytes = 0; bytes < file.size(); ++bytes) {
    EXPECT_EQ(code_of(device, std::span(file).first(bytes)), ErrorCode::InvalidData) << bytes;
    auto damaged = file;
    damaged[bytes] ^= std::byte{1};
    EXPECT_EQ(code_of(device, damaged), ErrorCode::InvalidData) << bytes;
  }
  auto longer = file;
  longer.push_back({});
  EXPECT_EQ(code_of(device, longer), ErrorCode::InvalidData);
}

TEST(PipelineCache, RejectsFilesOfOtherDevicesAndDrivers) {
  const auto device = some_device();
  const auto file = encode_pipeline_cache(device, data_of(device));
  auto driver = device, card = device, build = device;
  ++driver.driverVersion;
  ++card.deviceID;
  ++build.pipelineCacheUUID[15];
  for (const auto& other : {driver, card, build}) EXPECT_EQ(code_of(other, file), ErrorCode::InvalidData);
}

class PipelineCacheOnDisk : public testing::Test {
 protected:
  void SetUp() override {
    if (const auto& why = shared_vulkan.no_device()) GTEST_SKIP() << why->message;
  }

  // Runs a pass on its own device, which saves the cache file. Returns the content of the file.
  std::vector<std::byte> file_after_a_pass() {
    VulkanDeviceOptions options;
    options.pipeline_cache_folder = folder_ / "made" / "here";
    auto device = VulkanDevice::create(options);
    EXPECT_TRUE(device) << device.error().message;
    if (!device) return {};
    properties_ = (*device)->handles().properties;
    {
      const auto backend = create_vulkan_backend(*std::move(device));
      EXPECT_TRUE(backend) << backend.error().message;
      if (!backend) return {};
      auto words = Buffer::create(**backend, 400), shifted = Buffer::create(**backend, 400);
      EXPECT_TRUE(words && shifted && dispatch_shift_words(**backend, words->id(), shifted->id(), 100));
      EXPECT_TRUE((*backend)->submit());
    }
    const auto file = read_file(path());
    EXPECT_TRUE(file) << file.error().message;
    return file ? *file : std::vector<std::byte>();
  }
  std::filesystem::path path() const { return pipeline_cache_file(folder_ / "made" / "here", properties_); }

  ScratchFolder folder_;
  VkPhysicalDeviceProperties properties_{};
};

TEST_F(PipelineCacheOnDisk, DoesNotRewriteAnUnchangedCache) {
  (void)file_after_a_pass();
  const auto second = file_after_a_pass();  // a driver may extend its data once
  const auto written = std::filesystem::last_write_time(path());
  EXPECT_TRUE(decode_pipeline_cache(properties_, second));
  if (file_after_a_pass() == second) {
    EXPECT_EQ(std::filesystem::last_write_time(path()), written);
  }
}

TEST_F(PipelineCacheOnDisk, ReplacesADamagedFile) {
  auto file = file_after_a_pass();
  ASSERT_FALSE(file.empty());
  file.back() ^= std::byte{255};
  ASSERT_TRUE(write_file_atomically(path(), file));
  ASSERT_FALSE(decode_pipeline_cache(properties_, file));
  EXPECT_TRUE(decode_pipeline_cache(properties_, file_after_a_pass()));
}

// A failed write only costs time in the next run.
TEST_F(PipelineCacheOnDisk, IgnoresAnUnusableFolder) {
  folder_.write("made", "a file in the folder's place");
  VulkanDeviceOptions options;
  options.pipeline_cache_folder = folder_ / "made" / "here";
  const auto device = VulkanDevice::create(options);
  EXPECT_TRUE(device) << device.error().message;
}

}  // namespace
}  // namespace livegs
