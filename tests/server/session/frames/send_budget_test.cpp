// SPDX-License-Identifier: Apache-2.0
#include "session/frames/send_budget.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "session/rpc/asset_call.h"

namespace livegs {
namespace {

TEST(SendBudget, AccumulatesBrieflyAndAllowsDebt) {
  SendBudget free;
  EXPECT_FALSE(free.capped());
  EXPECT_EQ(free.available_bytes(5), std::numeric_limits<double>::infinity());
  SendBudget budget;
  budget.set_cap(1000);
  EXPECT_DOUBLE_EQ(budget.available_bytes(1'000'000'000), 100);
  budget.pay(350);
  EXPECT_DOUBLE_EQ(budget.available_bytes(1'100'000'000), -150);
  EXPECT_DOUBLE_EQ(budget.available_bytes(1'300'000'000), 50);
  EXPECT_DOUBLE_EQ(budget.available_bytes(1'200'000'000), 50);  // a clock that runs backwards adds nothing
  EXPECT_DOUBLE_EQ(budget.available_bytes(9'000'000'000), 100);
}

constexpr double kCap_bytes_s = 250'000;  // 2 Mbit/s
constexpr int64_t kMillisecond_ns = 1'000'000;

struct Sent {
  int64_t at_ns;
  double bytes;
};

// Ten seconds of a stream of 90 frames a second and of three fetches that always want more.
struct Share {
  std::vector<int64_t> frames_ns;         // when frames were sent
  std::vector<Sent> sent;                 // of frames and assets
  std::array<double, 3> fetched_bytes{};  // per fetch
  double frame_bytes = 0;
};
Share share_of(bool fetching, double most_frame_bytes) {
  Share share;
  SendBudget budget(kCap_bytes_s);
  std::minstd_rand random(1);
  std::uniform_real_distribution<double> frame_bytes(0.2 * most_frame_bytes, most_frame_bytes);
  std::array<int64_t, 3> asks_ns{};
  int64_t frame_ns = 0;
  for (int64_t now = kMillisecond_ns; now < 10'000 * kMillisecond_ns; now += kMillisecond_ns) {
    if (now >= frame_ns) {
      frame_ns += 11'111'111;
      const double bytes = frame_bytes(random);
      if (budget.available_bytes(now) > 0) {
        budget.pay(bytes);
        share.frame_bytes += bytes;
        share.frames_ns.push_back(now);
        share.sent.push_back({now, bytes});
      }
    }
    for (size_t i = 0; fetching && i < asks_ns.size(); ++i) {
      if (now < asks_ns[i]) continue;
      const auto turn = budget.take_turn(&asks_ns[i], kAssetChunkBytes, now);
      asks_ns[i] = now + turn.wait_ns;
      if (turn.bytes == 0) continue;
      share.fetched_bytes[i] += static_cast<double>(turn.bytes);
      share.sent.push_back({now, static_cast<double>(turn.bytes)});
    }
  }
  return share;
}

double most_in_a_second(const std::vector<Sent>& sent) {
  double most = 0;
  for (size_t from = 0; from < sent.size(); ++from) {
    double bytes = 0;
    for (size_t i = from; i < sent.size() && sent[i].at_ns < sent[from].at_ns + 1'000'000'000; ++i)
      bytes += sent[i].bytes;
    most = std::max(most, bytes);
  }
  return most;
}

TEST(SendBudget, AssetsTakeOnlyWhatFramesLeave) {
  const Share alone = share_of(false, 3000), shared = share_of(true, 3000);  // 1.3 Mbit/s on average
  EXPECT_EQ(shared.frames_ns, alone.frames_ns);
  EXPECT_EQ(shared.frame_bytes, alone.frame_bytes);
  EXPECT_LE(most_in_a_second(shared.sent), kCap_bytes_s * (1 + SendBudget::kBurst_s));
  // Nothing is wasted but the overhead of chunks and the waits, which are a millisecond too long.
  double all = shared.frame_bytes;
  for (const double bytes : shared.fetched_bytes) all += bytes;
  EXPECT_GT(all, 0.95 * 10 * kCap_bytes_s);
}

TEST(SendBudget, FetchesGetEqualShares) {
  const Share share = share_of(true, 3000);
  const auto [least, most] = std::minmax_element(share.fetched_bytes.begin(), share.fetched_bytes.end());
  EXPECT_GT(*least, 0);
  EXPECT_LE(*most - *least, kCap_bytes_s * SendBudget::kBurst_s * SendBudget::kChunkShare * 2);
}

TEST(SendBudget, FetchProgressesBelowFramesThatTakeEverything) {
  const Share share = share_of(true, 30'000);  // 13 Mbit/s
  double fetched = 0;
  for (const double bytes : share.fetched_bytes) {
    EXPECT_GT(bytes, 0);
    fetched += bytes;
  }
  EXPECT_LE(fetched, 0.02 * 10 * kCap_bytes_s);
}

TEST(SendBudget, FetchThatLeftIsNotWaitedFor) {
  SendBudget budget(kCap_bytes_s);
  int first = 0, second = 0;
  int64_t now = kMillisecond_ns;
  while (budget.take_turn(&first, 1000, now).bytes > 0) {
  }
  EXPECT_EQ(budget.take_turn(&second, 1000, now).bytes, 0u);  // the second in the queue
  budget.leave(&first);
  now += 100 * kMillisecond_ns;
  EXPECT_EQ(budget.take_turn(&second, 1000, now).bytes, 1000u);
}

}  // namespace
}  // namespace livegs
