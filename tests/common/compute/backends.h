// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/compute/shared_vulkan.h"
#include "compute/buffer.h"
#include "compute/cpu_backend.h"

namespace livegs {

// A test on one backend, selected by name. All Vulkan tests of a program share one device and backend with
// the validation layer. Skipped only if there is no Vulkan device; a missing layer fails.
class OnEveryBackend : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (GetParam() == std::string("cpu")) {
      backend_ = &cpu_;
      return;
    }
    if (const auto& why = shared_vulkan.no_device()) GTEST_SKIP() << why->message;
    const auto backend = shared_vulkan.backend();
    ASSERT_TRUE(backend) << backend.error().message;
    backend_ = *backend;
    RecordProperty("device", (*shared_vulkan.device())->name());
  }

  void TearDown() override {
    buffers_.clear();
    shared_vulkan.messages().expect_none();
  }

  // Destroyed at the end of the test.
  BufferId make_buffer(size_t bytes) {
    auto made = Buffer::create(*backend_, bytes);
    EXPECT_TRUE(made) << made.error().message;
    if (!made) return BufferId{};
    buffers_.push_back(*std::move(made));
    return buffers_.back().id();
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

  Backend* backend_ = nullptr;

 private:
  CpuBackend cpu_;
  std::vector<Buffer> buffers_;
};

inline std::string backend_name(const testing::TestParamInfo<const char*>& info) { return info.param; }

}  // namespace livegs
