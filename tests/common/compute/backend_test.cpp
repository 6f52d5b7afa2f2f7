// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <random>
#include <string>

#include "common/compute/backends.h"
#include "common/compute/shift_words.h"
#include "compute/vulkan_commands.h"

namespace livegs {
namespace {

using BackendTest = OnEveryBackend;
INSTANTIATE_TEST_SUITE_P(Backend, BackendTest, testing::Values("cpu", "vulkan"), backend_name);

std::vector<uint32_t> random_words(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<uint32_t> words(count);
  for (uint32_t& word : words) word = static_cast<uint32_t>(random());
  return words;
}

TEST_P(BackendTest, ReadReturnsUploadedData) {
  // One word, less than a staging buffer of 8 MiB, and more than one by an odd number of words.
  for (const size_t words : {size_t{1}, size_t{1000}, (size_t{1} << 21) + 3}) {
    const auto written = random_words(words, words);
    const BufferId buffer = make_buffer_of(written);
    EXPECT_EQ(read_all<uint32_t>(buffer, words), written);
  }
}

TEST_P(BackendTest, UploadWritesOnlyTheFront) {
  const auto written = random_words(100, 1);
  const BufferId buffer = make_buffer_of(written);
  const std::array<uint32_t, 2> front{1, 2};
  ASSERT_TRUE(backend_->upload(buffer, std::as_bytes(std::span(front))));
  auto expected = written;
  expected[0] = 1;
  expected[1] = 2;
  EXPECT_EQ(read_all<uint32_t>(buffer, 100), expected);
}

TEST_P(BackendTest, BuffersDoNotOverlapAfterReuse) {
  std::vector<std::pair<BufferId, std::vector<uint32_t>>> live;
  std::mt19937_64 random(7);
  for (int round = 0; round < 60; ++round) {
    if (live.size() > 6) {
      const size_t victim = random() % live.size();
      ASSERT_TRUE(backend_->destroy_buffer(live[victim].first));
      live.erase(live.begin() + static_cast<std::ptrdiff_t>(victim));
    }
    const auto words = random_words(1 + random() % 5000, random());
    live.emplace_back(make_buffer_of(words), words);
  }
  for (const auto& [buffer, words] : live) EXPECT_EQ(read_all<uint32_t>(buffer, words.size()), words);
}

TEST_P(BackendTest, RejectsTooLargeOrOddBuffers) {
  for (const size_t bytes : {kMaxBufferBytes + 4, SIZE_MAX - 3}) {
    const auto made = backend_->create_buffer(bytes);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::TooLarge) << made.error().message;
  }
  for (const size_t bytes : {size_t{0}, size_t{3}, size_t{6}}) {
    const auto made = backend_->create_buffer(bytes);
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument) << made.error().message;
  }
}

TEST_P(BackendTest, RejectsTransfersPastTheEnd) {
  const BufferId buffer = make_buffer(8);
  std::array<std::byte, 12> bytes{};
  for (const size_t count : {size_t{12}, size_t{3}}) {
    const auto up = backend_->upload(buffer, std::span(bytes).first(count));
    ASSERT_FALSE(up);
    EXPECT_EQ(up.error().code, ErrorCode::InvalidArgument);
    const auto down = backend_->read(buffer, std::span(bytes).first(count));
    ASSERT_FALSE(down);
    EXPECT_EQ(down.error().code, ErrorCode::InvalidArgument);
  }
}

TEST_P(BackendTest, ReportsUnknownBuffers) {
  const BufferId destroyed = make_buffer(48);
  ASSERT_TRUE(backend_->destroy_buffer(destroyed));
  const BufferId known = make_buffer(48);
  EXPECT_NE(known, destroyed);
  std::array<std::byte, 4> bytes{};
  for (const BufferId buffer : {destroyed, BufferId{0}, BufferId{1000000}}) {
    const std::array results{backend_->destroy_buffer(buffer), backend_->upload(buffer, bytes),
                             backend_->read(buffer, bytes),
                             dispatch_shift_words(*backend_, known, buffer, 1)};
    for (const auto& result : results) {
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code, ErrorCode::NotFound) << result.error().message;
    }
  }
}

TEST_P(BackendTest, RejectsDispatchesThatDoNotFitThePass) {
  const Pass& pass = shift_words_pass();
  const BufferId a = make_buffer(48);
  const BufferId b = make_buffer(48);
  const std::array<std::byte, sizeof(uint32_t)> constants{};
  const auto code = [&](std::vector<BufferId> buffers, std::span<const std::byte> bytes) {
    const auto done = backend_->dispatch(pass, buffers, bytes, 1);
    return done ? ErrorCode::Internal : done.error().code;
  };
  EXPECT_EQ(code({a}, constants), ErrorCode::InvalidArgument);
  EXPECT_EQ(code({a, a}, constants), ErrorCode::InvalidArgument);
  EXPECT_EQ(code({a, b}, std::span(constants).first(0)), ErrorCode::InvalidArgument);
}

TEST_P(BackendTest, LeavesItemsPastTheCountUnchanged) {
  const uint32_t count = shift_words_pass().group_size + 1;
  const auto words = random_words(2 * count, 3), before = random_words(2 * count, 4);
  const BufferId shifted = make_buffer_of(before);
  ASSERT_TRUE(dispatch_shift_words(*backend_, make_buffer_of(words), shifted, count));
  const auto after = read_all<uint32_t>(shifted, 2 * count);
  for (uint32_t i = 0; i < 2 * count; ++i)
    EXPECT_EQ(after[i], i < count ? words[(i + 1) % count] + 1 : before[i]) << i;
}

// Each dispatch reads the output of the previous one; the chain exceeds one command buffer. A missing barrier
// is a data race, which the validation layer also reports.
TEST_P(BackendTest, DispatchesReadEarlierResults) {
  constexpr uint32_t kRounds = 150;  // 300 dispatches; a command buffer has 256
  const auto words = random_words(1000, 8);
  const BufferId a = make_buffer_of(words);
  const BufferId b = make_buffer(4 * words.size());
  for (uint32_t round = 0; round < kRounds; ++round) {
    ASSERT_TRUE(dispatch_shift_words(*backend_, a, b, 1000));
    ASSERT_TRUE(dispatch_shift_words(*backend_, b, a, 1000));
  }
  const auto after = read_all<uint32_t>(a, words.size());
  for (uint32_t i = 0; i < words.size(); ++i)
    ASSERT_EQ(after[i], words[(i + 2 * kRounds) % 1000] + 2 * kRounds) << i;
}

// Uploads are ordered with dispatches: each dispatch reads the latest upload before it, although all of them
// run together and the staging buffer fills several times.
TEST_P(BackendTest, UploadsAffectOnlyLaterDispatches) {
  constexpr uint32_t kWords = 700'000;  // three uploads fill the staging buffer
  const BufferId words = make_buffer(4 * kWords);
  std::vector<BufferId> shifted;
  for (uint32_t round = 0; round < 10; ++round) {
    const std::vector<uint32_t> uploaded(kWords, 100 * round);
    ASSERT_TRUE(backend_->upload(words, std::as_bytes(std::span(uploaded))));
    shifted.push_back(make_buffer(4 * kWords));
    ASSERT_TRUE(dispatch_shift_words(*backend_, words, shifted.back(), kWords));
  }
  for (uint32_t round = 0; round < 10; ++round)
    EXPECT_EQ(read_all<uint32_t>(shifted[round], kWords), std::vector<uint32_t>(kWords, 100 * round + 1))
        << round;
}

TEST_P(BackendTest, UploadsAndDispatchesAreOneSubmission) {
  VulkanCommands* commands = vulkan_commands(*backend_);
  if (!commands) GTEST_SKIP() << "the CPU submits nothing";
  const BufferId a = make_buffer(4000), b = make_buffer(4000);
  const VulkanCommands::Traffic before = commands->traffic();
  for (uint32_t round = 0; round < 20; ++round) {
    const auto words = random_words(1000, round);
    ASSERT_TRUE(backend_->upload(a, std::as_bytes(std::span(words))));
    ASSERT_TRUE(dispatch_shift_words(*backend_, a, b, 1000));
  }
  ASSERT_TRUE(backend_->submit());
  EXPECT_EQ(commands->traffic().submissions - before.submissions, 1u);
  EXPECT_EQ(commands->traffic().uploaded_bytes - before.uploaded_bytes, 20u * 4000u);
  EXPECT_EQ(commands->traffic().dispatches - before.dispatches, 20u);
  EXPECT_EQ(commands->traffic().barriers - before.barriers, 20u + 20u);  // before each upload and dispatch
}

// Valid with and without a loader: an existing loader gets an invalid driver path.
TEST(VulkanDevice, ReportsAMissingDevice) {
  std::map<const char*, std::optional<std::string>> before;  // both variables of the loader, old and new
  for (const char* variable : {"VK_ICD_FILENAMES", "VK_DRIVER_FILES"}) {
    if (const char* drivers = std::getenv(variable))
      before[variable] = drivers;
    else
      before[variable] = std::nullopt;
    setenv(variable, "/nonexistent/driver.json", 1);
  }
  const auto device = VulkanDevice::create();
  for (const auto& [variable, drivers] : before)
    drivers ? setenv(variable, drivers->c_str(), 1) : unsetenv(variable);
  ASSERT_FALSE(device);
  EXPECT_EQ(device.error().code, ErrorCode::Unavailable);
  EXPECT_EQ(device.error().message.find("vulkan: no "), 0u) << device.error().message;
  EXPECT_NE(device.error().message.find("install the GPU's driver, or the package mesa-vulkan-drivers"),
            std::string::npos)
      << device.error().message;
  EXPECT_EQ(device.error().message.find('\n'), std::string::npos) << device.error().message;
}

}  // namespace
}  // namespace livegs
