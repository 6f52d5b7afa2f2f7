// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "compute/cpu_backend.h"
#include "compute/vulkan_backend.h"

namespace livegs {

// What the validation layer said, from any thread.
class ValidationMessages {
 public:
  void add(const std::string& message) {
    const std::lock_guard lock(mutex_);
    messages_.push_back(message);
  }
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(messages_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> messages_;
};

// A test on one backend, by its name. Vulkan runs under the validation layer, and any message fails the test,
// those about what was left undestroyed included. Skips only where there is no Vulkan device; a missing layer
// fails.
class OnEveryBackend : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (GetParam() == std::string("cpu")) {
      backend_ = std::make_unique<CpuBackend>();
      return;
    }
    auto plain = VulkanDevice::create();
    if (!plain) GTEST_SKIP() << plain.error().message;
    VulkanDeviceOptions options;
    options.validation = true;
    options.on_validation_message = [this](const std::string& message) { messages_.add(message); };
    auto device = VulkanDevice::create(options);
    ASSERT_TRUE(device) << device.error().message;
    RecordProperty("device", (*device)->name());
    auto backend = create_vulkan_backend(*std::move(device));
    ASSERT_TRUE(backend) << backend.error().message;
    backend_ = *std::move(backend);
  }

  void TearDown() override {
    backend_.reset();
    for (const std::string& message : messages_.take()) ADD_FAILURE() << message;
  }

  BufferId make_buffer(size_t bytes) {
    auto made = backend_->create_buffer(bytes);
    EXPECT_TRUE(made) << made.error().message;
    return made ? *made : BufferId{};
  }

  template <class Row>
  BufferId make_buffer_of(const std::vector<Row>& rows) {
    const BufferId buffer = make_buffer(rows.size() * sizeof(Row));
    const auto done = backend_->upload(buffer, std::as_bytes(std::span(rows)));
    EXPECT_TRUE(done) << done.error().message;
    return buffer;
  }

  template <class Row>
  std::vector<Row> read_all(BufferId buffer, size_t count) {
    std::vector<Row> rows(count);
    const auto done = backend_->read(buffer, std::as_writable_bytes(std::span(rows)));
    EXPECT_TRUE(done) << done.error().message;
    return rows;
  }

  ValidationMessages messages_;  // outlives the backend, which speaks until it is gone
  std::unique_ptr<Backend> backend_;
};

inline std::string backend_name(const testing::TestParamInfo<const char*>& info) { return info.param; }

}  // namespace livegs
