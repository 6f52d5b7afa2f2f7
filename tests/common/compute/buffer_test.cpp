// SPDX-License-Identifier: Apache-2.0
#include "compute/buffer.h"

#include <gtest/gtest.h>

#include <array>

#include "compute/cpu_backend.h"

namespace livegs {
namespace {

bool exists(Backend& backend, BufferId id) {
  std::array<std::byte, 4> bytes;
  return static_cast<bool>(backend.read(id, bytes));
}

TEST(Buffer, IsDestroyedWithItsOwner) {
  CpuBackend backend;
  BufferId id{};
  {
    const auto made = Buffer::create(backend, 8);
    ASSERT_TRUE(made) << made.error().message;
    id = made->id();
    EXPECT_EQ(made->bytes(), 8u);
    EXPECT_TRUE(exists(backend, id));
  }
  EXPECT_FALSE(exists(backend, id));
}

TEST(Buffer, SurvivesAMove) {
  CpuBackend backend;
  Buffer last;
  EXPECT_FALSE(last);
  BufferId id{};
  {
    auto made = Buffer::create(backend, 8);
    ASSERT_TRUE(made);
    id = made->id();
    Buffer first = *std::move(made);
    last = std::move(first);
    EXPECT_FALSE(first);
  }
  EXPECT_EQ(last.id(), id);
  EXPECT_TRUE(exists(backend, id));
  last.reset();
  EXPECT_FALSE(last);
  EXPECT_EQ(last.bytes(), 0u);
  EXPECT_FALSE(exists(backend, id));
}

TEST(Buffer, ReturnsErrorsOfItsBackend) {
  CpuBackend backend;
  const auto made = Buffer::create(backend, 3);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, ErrorCode::InvalidArgument);
}

}  // namespace
}  // namespace livegs
