// SPDX-License-Identifier: Apache-2.0
// The window against simulated links and clients, in simulated time.
#include "session/frames/window_size.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <vector>

namespace livegs {
namespace {

constexpr double kTick_ms = 1000.0 / 90;

// A path to a client and back. A frame takes `service_ms` of a serial resource, the link or the client.
struct Way {
  double service_ms = 0, round_trip_ms = 0, jitter_ms = 0;
  double stall_every_ms = 0, stall_ms = 0;
  std::optional<double> less_ms = {};  // replaces service_ms for frames reduced because the client is slow
};

struct Trial {
  std::vector<double> ages_ms, sent_ms;  // age of each frame on arrival, and the arrival time
  std::vector<size_t> windows;           // at each arrival
  std::vector<bool> slow;                // likewise
  double slow_share(double begin_ms, double end_ms) const {
    double all = 0, those = 0;
    for (size_t i = 0; i < slow.size(); ++i) {
      if (sent_ms[i] < begin_ms || sent_ms[i] >= end_ms) continue;
      ++all;
      those += slow[i] ? 1 : 0;
    }
    return those / all;
  }
  double rate_hz(double begin_ms, double end_ms) const {
    const auto count =
        std::count_if(sent_ms.begin(), sent_ms.end(), [&](double t) { return t >= begin_ms && t < end_ms; });
    return 1e3 * static_cast<double>(count) / (end_ms - begin_ms);
  }
  double age_ms(double share, double begin_ms, double end_ms) const {
    std::vector<double> ages;
    for (size_t i = 0; i < ages_ms.size(); ++i) {
      if (sent_ms[i] >= begin_ms && sent_ms[i] < end_ms) ages.push_back(ages_ms[i]);
    }
    std::sort(ages.begin(), ages.end());
    return ages.at(static_cast<size_t>(share * static_cast<double>(ages.size() - 1)));
  }
};

// Ninety ticks a second; the newest waits for the window, as in SendWindow. `fixed`: a constant window that
// replaces WindowSize.
Trial run(double seconds, const std::function<Way(double)>& way_at, size_t fixed = 0) {
  WindowSize size;
  std::mt19937_64 random(1);
  struct Under {
    double written_ms = 0, arrives_ms = 0, acknowledged_ms = 0, tick_ms = 0;
    bool alone = false;
  };
  std::deque<Under> under_way;
  Trial result;
  double free_ms = 0, newest_ms = -1, arrived_ms = 0;
  bool waits = false;
  double next_tick_ms = 0, now_ms = 0;
  while (now_ms < 1e3 * seconds) {
    // The next event: a tick or an acknowledgement.
    if (!under_way.empty() && under_way.front().acknowledged_ms <= next_tick_ms) {
      const Under one = under_way.front();
      under_way.pop_front();
      now_ms = one.acknowledged_ms;
      size.add(
          {static_cast<int64_t>(1e6 * one.written_ms), static_cast<int64_t>(1e6 * now_ms), one.alone, 1});
    } else {
      now_ms = next_tick_ms;
      next_tick_ms += kTick_ms;
      newest_ms = now_ms;
      waits = true;
    }
    if (!waits || under_way.size() >= (fixed > 0 ? fixed : size.frames())) continue;
    const Way way = way_at(now_ms);
    Under one{now_ms, 0, 0, newest_ms, under_way.empty()};
    const bool slow = size.slow(static_cast<int64_t>(1e6 * now_ms));
    free_ms = std::max(free_ms, now_ms) + (slow ? way.less_ms.value_or(way.service_ms) : way.service_ms);
    if (way.stall_every_ms > 0) {
      const double within = std::fmod(free_ms, way.stall_every_ms);
      if (within < way.stall_ms && free_ms > way.stall_every_ms) free_ms += way.stall_ms - within;
    }
    const double jitter_ms = std::uniform_real_distribution<double>(0, way.jitter_ms + 1e-9)(random);
    arrived_ms = one.arrives_ms = std::max(arrived_ms, free_ms + way.round_trip_ms / 2 + jitter_ms);
    const double acknowledged_before_ms = under_way.empty() ? 0 : under_way.back().acknowledged_ms;
    one.acknowledged_ms = std::max(acknowledged_before_ms, one.arrives_ms + way.round_trip_ms / 2);
    under_way.push_back(one);
    result.ages_ms.push_back(one.arrives_ms - one.tick_ms);
    result.sent_ms.push_back(one.arrives_ms);
    result.windows.push_back(fixed > 0 ? fixed : size.frames());
    result.slow.push_back(slow);
    waits = false;
  }
  return result;
}

Trial run(double seconds, const Way& way, size_t fixed = 0) {
  return run(
      seconds, [&](double) { return way; }, fixed);
}

size_t usual_window(const Trial& result) {
  std::vector<size_t> last(result.windows.begin() + static_cast<std::ptrdiff_t>(result.windows.size() / 2),
                           result.windows.end());
  std::sort(last.begin(), last.end());
  return last[last.size() / 2];
}

TEST(WindowSize, IsTwoOnALan) {
  const Trial lan = run(20, {.service_ms = 0.3, .round_trip_ms = 1});
  EXPECT_NEAR(lan.rate_hz(1e3, 20e3), 90, 0.5);
  EXPECT_TRUE(std::all_of(lan.windows.begin(), lan.windows.end(), [](size_t size) { return size == 2; }));
}

TEST(WindowSize, KeepsTheRateOverLongRoundTrips) {
  const Way far{.service_ms = 0.3, .round_trip_ms = 40};
  const Trial two = run(20, far, 2), adapted = run(20, far);
  EXPECT_NEAR(two.rate_hz(2e3, 20e3), 50, 1);
  EXPECT_NEAR(adapted.rate_hz(2e3, 20e3), 90, 0.5);
  EXPECT_EQ(usual_window(adapted), 4u);
  EXPECT_LE(adapted.age_ms(0.99, 2e3, 20e3), two.age_ms(0.99, 2e3, 20e3));
}

TEST(WindowSize, GrowsWithTheRoundTripUpToFour) {
  for (const auto& [round_trip_ms, window] : {std::pair{5.0, 2u}, {15.0, 3u}, {25.0, 4u}, {200.0, 4u}}) {
    EXPECT_EQ(usual_window(run(20, {.service_ms = 0.3, .round_trip_ms = round_trip_ms})), window)
        << round_trip_ms;
  }
}

// 16 kB at 8 Mbit/s take 16 ms, longer than a tick. An acknowledgement takes 18 ms alone, 34 ms behind one
// frame and 66 ms behind three. Taken as network latency, these values would open the window that causes
// them.
TEST(WindowSize, AvoidsQueuesInANarrowLink) {
  const Way narrow{.service_ms = 16, .round_trip_ms = 2};
  const Trial adapted = run(60, narrow), two = run(60, narrow, 2), four = run(60, narrow, 4);
  std::printf("narrow: p99 %.1f then %.1f ms at %.1f a second; of two %.1f ms at %.1f; of four %.1f ms\n",
              adapted.age_ms(0.99, 1e3, 30e3), adapted.age_ms(0.99, 30e3, 60e3), adapted.rate_hz(1e3, 60e3),
              two.age_ms(0.99, 1e3, 60e3), two.rate_hz(1e3, 60e3), four.age_ms(0.99, 1e3, 60e3));
  EXPECT_LT(adapted.age_ms(0.5, 1e3, 60e3), 0.7 * two.age_ms(0.5, 1e3, 60e3));
  EXPECT_LE(adapted.age_ms(0.99, 1e3, 60e3), two.age_ms(0.99, 1e3, 60e3));
  EXPECT_LE(adapted.age_ms(0.99, 30e3, 60e3), 1.05 * adapted.age_ms(0.99, 1e3, 30e3));  // flat
  EXPECT_GT(four.age_ms(0.99, 1e3, 60e3),
            60);  // a window from the round trip alone exceeds the bar
  EXPECT_GT(adapted.rate_hz(1e3, 60e3), 0.8 * two.rate_hz(1e3, 60e3));
  EXPECT_EQ(usual_window(adapted), 1u);
}

// A long, narrow link is filled without a queue.
TEST(WindowSize, FillsALongNarrowLink) {
  const Way way{.service_ms = 16, .round_trip_ms = 40};
  const Trial adapted = run(60, way), four = run(60, way, 4);
  EXPECT_GT(adapted.rate_hz(5e3, 60e3), 0.8 * four.rate_hz(5e3, 60e3));
  EXPECT_LE(adapted.age_ms(0.99, 5e3, 60e3), four.age_ms(0.99, 5e3, 60e3) + 1);
}

// The reference is twice the client's frame time; once is enough to lose nothing.
TEST(WindowSize, IsOneForASlowClient) {
  const Way slow{.service_ms = 200, .round_trip_ms = 1};
  const Trial adapted = run(120, slow), two = run(120, slow, 2);
  EXPECT_LT(adapted.age_ms(0.5, 20e3, 120e3), 0.6 * two.age_ms(0.5, 20e3, 120e3));
  EXPECT_GT(adapted.rate_hz(20e3, 120e3), 0.95 * two.rate_hz(20e3, 120e3));
}

TEST(WindowSize, FollowsALinkThatNarrowsAndWidens) {
  const Trial changing = run(90, [](double now_ms) {
    const bool narrow = now_ms >= 30e3 && now_ms < 60e3;
    return Way{.service_ms = narrow ? 16.0 : 0.3, .round_trip_ms = 2};
  });
  EXPECT_NEAR(changing.rate_hz(1e3, 30e3), 90, 0.5);
  EXPECT_LT(changing.age_ms(0.5, 32e3, 60e3), 30);
  EXPECT_NEAR(changing.rate_hz(61e3, 90e3), 90, 0.5);
  EXPECT_EQ(changing.windows.back(), 2u);
}

TEST(WindowSize, IsNotSlowWithoutCongestion) {
  for (const Way& way : {Way{.service_ms = 0.3, .round_trip_ms = 1}, Way{.service_ms = 6, .round_trip_ms = 2},
                         Way{.service_ms = 0.3, .round_trip_ms = 40},
                         Way{.service_ms = 0.3, .round_trip_ms = 2, .jitter_ms = 5}}) {
    EXPECT_EQ(run(60, way).slow_share(0, 60e3), 0) << way.round_trip_ms;
  }
}

// Whole frames do not fit, smaller ones do. This is detected within a second and kept, with retries at
// growing intervals. A link that widens again is detected too.
TEST(WindowSize, IsSlowWhileWholeFramesDoNotFit) {
  const Trial changing = run(400, [](double now_ms) {
    const bool narrow = now_ms < 200e3;
    return Way{.service_ms = narrow ? 16.0 : 0.3, .round_trip_ms = 2, .less_ms = narrow ? 6.0 : 0.3};
  });
  std::printf("slow in %.3f of the frames from 1 to 100 s, %.3f to 200 s; %.1f frames a second\n",
              changing.slow_share(1e3, 100e3), changing.slow_share(100e3, 200e3),
              changing.rate_hz(1e3, 200e3));
  EXPECT_GT(changing.slow_share(1e3, 100e3), 0.95);
  EXPECT_GT(changing.slow_share(100e3, 200e3), 0.97);
  EXPECT_GT(changing.rate_hz(1e3, 200e3), 88);
  EXPECT_EQ(changing.slow_share(245e3, 400e3), 0);
}

TEST(WindowSize, IsSlowBehindALongNarrowLink) {
  EXPECT_GT(run(60, {.service_ms = 16, .round_trip_ms = 40}).slow_share(5e3, 60e3), 0.95);
}

// A stall is not network latency.
TEST(WindowSize, IsNotOpenedByStalls) {
  const Trial stalled =
      run(60, {.service_ms = 0.3, .round_trip_ms = 2, .stall_every_ms = 2000, .stall_ms = 300});
  EXPECT_TRUE(
      std::all_of(stalled.windows.begin(), stalled.windows.end(), [](size_t size) { return size <= 2; }));
}

TEST(WindowSize, KeepsTheRateUnderJitter) {
  const Trial jittery = run(60, {.service_ms = 0.3, .round_trip_ms = 2, .jitter_ms = 20});
  EXPECT_GT(jittery.rate_hz(2e3, 60e3), 85);
}

// The round trip is at the boundary of two sizes: noise of a tenth of a tick must not change the window
// repeatedly.
TEST(WindowSize, DoesNotOscillate) {
  const Trial edge = run(60, [](double now_ms) {
    return Way{.service_ms = 0.1,
               .round_trip_ms = kTick_ms * (1 + (std::fmod(now_ms, 2000) < 1000 ? 0.1 : -0.1))};
  });
  size_t changes = 0;
  for (size_t i = 1; i < edge.windows.size(); ++i) changes += edge.windows[i] != edge.windows[i - 1] ? 1 : 0;
  EXPECT_LE(changes, 2u);
}

}  // namespace
}  // namespace livegs
