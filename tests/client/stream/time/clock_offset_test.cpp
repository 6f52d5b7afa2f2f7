// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/percentile.h"
#include "stream/time/clock_offset.h"

namespace livegs {
namespace {

constexpr int64_t kMs = 1'000'000;

struct Network {
  double delay_ms = 1, jitter_ms = 20;  // each way: uniform between delay and delay + jitter, in order
  double drift = 0;                     // of the server's clock
  double messages_hz = 90;              // each way
};

// Errors and reported uncertainties in ms at every frame of a minute, except the first two seconds, for an
// offset of three hours.
struct Trace {
  std::vector<double> errors_ms, uncertainties_ms;
};
Trace trace(const Network& network, uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto travel_ns = [&] {
    return static_cast<int64_t>(
        1e6 * (network.delay_ms + std::uniform_real_distribution<>(0, network.jitter_ms)(random)));
  };
  const auto server_from_client = [&](int64_t client_ns) {
    return 10'800'000 * kMs + client_ns +
           static_cast<int64_t>(network.drift * static_cast<double>(client_ns));
  };
  const auto period_ns = static_cast<int64_t>(1e9 / network.messages_hz);
  Trace result;
  ClockOffset clock;
  int64_t server_received_at = 0, received_at = 0, newest_sent = -1, newest_received = 0;  // client clock
  std::vector<std::pair<int64_t, int64_t>> up;  // sent, received by the server
  for (int64_t sent = 0; sent < 60'000 * kMs; sent += period_ns) {
    server_received_at = std::max(server_received_at, sent + travel_ns());
    up.emplace_back(sent, server_received_at);
  }
  size_t next = 0;
  int64_t echoed = -1;
  for (int64_t answered = period_ns / 3; answered < 60'000 * kMs; answered += period_ns) {
    while (next < up.size() && up[next].second <= answered) {
      newest_sent = up[next].first;
      newest_received = up[next++].second;
    }
    received_at = std::max(received_at, answered + travel_ns());
    if (newest_sent > echoed) {
      echoed = newest_sent;
      clock.add(
          {newest_sent, server_from_client(newest_received), server_from_client(answered), received_at});
    }
    const auto estimate = clock.at(received_at);
    if (!estimate || received_at < 2'000 * kMs) continue;
    const int64_t truth = server_from_client(received_at) - received_at;
    result.errors_ms.push_back(std::abs(1e-6 * static_cast<double>(estimate->offset_ns - truth)));
    result.uncertainties_ms.push_back(1e-6 * static_cast<double>(estimate->uncertainty_ns));
  }
  return result;
}

// 20 ms of jitter; clocks drift apart or together by 200 ppm.
TEST(ClockOffset, ErrorIsBelow1MsUnderJitterAndDrift) {
  for (const double drift : {200e-6, -200e-6, 0.0}) {
    std::vector<double> all;
    for (uint64_t seed = 1; seed <= 20; ++seed) {
      const Trace one = trace({.drift = drift}, seed);
      ASSERT_GT(one.errors_ms.size(), 1000u);
      all.insert(all.end(), one.errors_ms.begin(), one.errors_ms.end());
    }
    std::printf("drift %+.0f ppm: error p50 %.2f ms, p99 %.2f ms\n", 1e6 * drift, percentile(all, 0.5),
                percentile(all, 0.99));
    EXPECT_LE(percentile(all, 0.99), 1.0) << drift;
  }
}

// An idle client sends a keepalive every 50 ms.
TEST(ClockOffset, ErrorIsBelow1MsAt20Hz) {
  std::vector<double> all;
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    const Trace one = trace({.drift = 200e-6, .messages_hz = 20}, seed);
    all.insert(all.end(), one.errors_ms.begin(), one.errors_ms.end());
  }
  std::printf("20 Hz: error p50 %.2f ms, p99 %.2f ms\n", percentile(all, 0.5), percentile(all, 0.99));
  EXPECT_LE(percentile(all, 0.99), 1.0);
}

// The true offset is always between two bounds, whatever the jitter.
TEST(ClockOffset, ErrorIsWithinReportedUncertainty) {
  for (const double drift : {200e-6, -200e-6, 0.0}) {
    for (const double delay_ms : {0.1, 30.0}) {
      const Trace one = trace({.delay_ms = delay_ms, .drift = drift}, 3);
      for (size_t i = 0; i < one.errors_ms.size(); ++i)
        ASSERT_LE(one.errors_ms[i], one.uncertainties_ms[i] + 1e-5);
      // The uncertainty is useful: half the round trip, plus the effect of jitter and drift in a window.
      EXPECT_LE(percentile(one.uncertainties_ms, 0.99), delay_ms + 3.0);
    }
  }
}

// Both directions take equally long without queuing: NTP's midpoint.
TEST(ClockOffset, SingleSampleGivesMidpoint) {
  ClockOffset clock;
  EXPECT_FALSE(clock.at(0));
  clock.add({1'000, 7'500, 8'000, 3'500});  // 1000 each way, 5500 ahead; reply after 500
  const auto estimate = clock.at(3'500);
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->offset_ns, 5'000 + 500);
  EXPECT_EQ(estimate->uncertainty_ns, 1'000);
}

TEST(ClockOffset, FollowsClockAdjustment) {
  for (const int64_t step_ms : {5'000, -5'000}) {
    ClockOffset clock;
    int64_t now = 0;
    for (; now < 3'000 * kMs; now += 11 * kMs) clock.add({now, now + kMs, now + kMs, now + 2 * kMs});
    EXPECT_NEAR(static_cast<double>(clock.at(now)->offset_ns), 0.0, 1e3);
    // The first sample after the step is decisive.
    clock.add({now, now + (1 + step_ms) * kMs, now + (1 + step_ms) * kMs, now + 2 * kMs});
    EXPECT_NEAR(static_cast<double>(clock.at(now + 2 * kMs)->offset_ns), static_cast<double>(step_ms * kMs),
                1e3);
  }
}

}  // namespace
}  // namespace livegs
