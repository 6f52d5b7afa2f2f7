// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "stream/time/tick_aim.h"

namespace livegs {
namespace {

constexpr double kPeriod_ms = 1e3 / 90;
constexpr double kServerAhead_ms = 7'200'000;  // clock offset

int64_t ns(double ms) { return static_cast<int64_t>(1e6 * ms); }

// Samples at 90 Hz with jitter (ms) each way, in order: the latency of each until it is applied, ms.
struct Applied {
  std::vector<double> delays_ms;
  size_t late = 0;  // arrived after their tick had begun
  double spread_ms() {
    std::sort(delays_ms.begin(), delays_ms.end());
    const auto at = [&](double share) {
      return delays_ms[static_cast<size_t>(share * static_cast<double>(delays_ms.size() - 1))];
    };
    return at(0.95) - at(0.05);
  }
};
Applied apply(double jitter_ms, bool aims) {
  std::mt19937_64 random(5);
  const auto travel_ms = [&] {
    return 0.5 + std::uniform_real_distribution<>(0, std::max(jitter_ms, 1e-9))(random);
  };
  TickAim aim(90);
  Applied applied;
  double up_ms = 0, down_ms = 0;
  std::vector<std::pair<double, uint64_t>> frames;  // arrival, tick
  for (uint64_t tick = 1; tick <= 2000; ++tick) {
    down_ms = std::max(down_ms, kPeriod_ms * static_cast<double>(tick) + travel_ms());
    frames.emplace_back(down_ms, tick);
  }
  size_t seen = 0;
  for (double now_ms = 3.0; now_ms < 1900 * kPeriod_ms; now_ms += kPeriod_ms) {
    for (; seen < frames.size() && frames[seen].first <= now_ms; ++seen) {
      const uint64_t tick = frames[seen].second;
      aim.add_frame(tick, ns(kServerAhead_ms + kPeriod_ms * static_cast<double>(tick)));
    }
    const uint64_t meant = aims ? aim.tick_at(ns(now_ms)) : 0;
    up_ms = std::max(up_ms, now_ms + travel_ms());
    const auto arrives = static_cast<uint64_t>(std::ceil(up_ms / kPeriod_ms));  // the first possible tick
    if (meant > 0 && meant < arrives) ++applied.late;
    if (now_ms > 1000) {
      applied.delays_ms.push_back(kPeriod_ms * static_cast<double>(std::max(meant, arrives)) - now_ms);
    }
    aim.arrived(ns(now_ms), ns(kServerAhead_ms + up_ms));
  }
  return applied;
}

TEST(TickAim, AppliesSamplesEvenlyUnderJitter) {
  Applied plain = apply(20, false), aimed = apply(20, true);
  std::printf("spread p5 to p95: %.1f ms on arrival, %.1f ms aimed; %zu of %zu late\n", plain.spread_ms(),
              aimed.spread_ms(), aimed.late, aimed.delays_ms.size());
  // Samples and ticks have the same rate here, so all but the late 5 % have equal latency, or differ by a
  // period when the estimate crosses a tick boundary.
  EXPECT_LE(aimed.spread_ms(), kPeriod_ms + 0.1);
  EXPECT_GT(plain.spread_ms(), 1.5 * kPeriod_ms);
  EXPECT_LT(aimed.late, aimed.delays_ms.size() / 10);
  // The added latency is at most the jitter and a period.
  EXPECT_LE(aimed.delays_ms.back(), 0.5 + 20 + 2 * kPeriod_ms);
}

TEST(TickAim, IsNextTickOnQuietNetwork) {
  Applied plain = apply(0, false), aimed = apply(0, true);
  EXPECT_EQ(aimed.late, 0u);
  EXPECT_EQ(plain.delays_ms, aimed.delays_ms);
}

TEST(TickAim, IsZeroAtFirstAndBoundedLater) {
  TickAim aim(90);
  EXPECT_EQ(aim.tick_at(0), 0u);
  aim.add_frame(100, 0);
  EXPECT_EQ(aim.tick_at(0), 0u);
  aim.arrived(0, ns(1));
  EXPECT_EQ(aim.tick_at(ns(5)), 101u);
  EXPECT_EQ(aim.tick_at(ns(100)), 110u);  // 101 ms are 9.1 periods
  EXPECT_EQ(aim.tick_at(ns(1000)), 0u);
}

}  // namespace
}  // namespace livegs
