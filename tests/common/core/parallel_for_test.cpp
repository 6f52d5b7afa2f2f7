// SPDX-License-Identifier: Apache-2.0
#include "core/parallel_for.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <new>
#include <numeric>
#include <vector>

namespace livegs {
namespace {

TEST(ParallelFor, VisitsEachItemOnce) {
  for (size_t count : {0u, 1u, 63u, 64u, 65u, 1000u}) {
    std::vector<int> visits(count, 0);
    parallel_for(count, 64, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) ++visits[i];
    });
    EXPECT_EQ(std::accumulate(visits.begin(), visits.end(), size_t{0}), count);
  }
}

TEST(ParallelFor, BlockSumsAreIndependentOfThreadCount) {
  const auto sum = [](int threads) {
    set_thread_count(threads);
    std::vector<float> partial(100, 0.0f);
    parallel_for(100'000, 1000, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) partial[begin / 1000] += std::sin(static_cast<float>(i));
    });
    return std::accumulate(partial.begin(), partial.end(), 0.0f);
  };
  const float one = sum(1);
  EXPECT_EQ(one, sum(2));
  EXPECT_EQ(one, sum(5));
  set_thread_count(0);
}

// An exception is rethrown after all bodies have returned.
TEST(ParallelFor, RethrowsExceptionsToTheCaller) {
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    std::atomic<int> running{0};
    const auto body = [&](size_t begin, size_t) {
      ++running;
      const bool throws = begin == 500;
      --running;
      if (throws) throw std::bad_alloc();
    };
    EXPECT_THROW(parallel_for(1000, 10, body), std::bad_alloc);
    EXPECT_EQ(running, 0);
    EXPECT_THROW(parallel_for(1, 10, [](size_t, size_t) { throw std::bad_alloc(); }), std::bad_alloc);
  }
  set_thread_count(0);
}

}  // namespace
}  // namespace livegs
