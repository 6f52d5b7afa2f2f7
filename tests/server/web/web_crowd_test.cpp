// SPDX-License-Identifier: GPL-3.0-or-later
// Twenty browsers and ten native clients watch one scene while others hold a thousand connections half open
// and send a request byte by byte. Compares times, so it runs nightly and alone.
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <thread>
#include <vector>

#include "server/session/rpc/grpc_server_fixture.h"
#include "server/web/browser_socket.h"

namespace livegs {
namespace {

constexpr size_t kBrowsers = 20, kNative = 10, kHalfOpen = 1000, kSlow = 50;
constexpr int kTicks = 900, kRounds = 6;  // each of kTicks / kRounds ticks; quiet and crowded in turn
constexpr auto kPeriod = std::chrono::milliseconds(22);
// Bar of the crowded p99, and what a scheduler of a shared machine adds to it, ms.
constexpr double kMaxRatio = 1.1, kSlack_ms = 1.0;

// Ages of frames at their arrival, ms, by phase.
struct Ages {
  std::vector<double> of_phase[2];
};

double p99(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

class WebCrowdTest : public GrpcServerTest {
 protected:
  void take(const v1::ServerMessage& message, Ages& ages) const {
    if (message.frame().empty()) return;
    ages.of_phase[crowded_.load() ? 1 : 0].push_back(milliseconds_from_ns(now_ns() - message.stepped_ns()));
  }
  void browse(Ages& ages) {
    v1::JoinRequest wish;
    wish.set_protocol_version(kProtocolVersion);
    wish.set_client_name("a browser");
    Wire wire(server_->port());
    wire.send(request("POST", "/livegs.v1.LiveGs/Join", wish.SerializeAsString()));
    v1::JoinReply joined;
    EXPECT_TRUE(joined.ParseFromString(wire.answer().body));
    BrowserSocket socket(server_->port());
    EXPECT_EQ(socket.upgrade.status, 101);
    v1::ClientMessage answer;
    answer.set_session_id(joined.session_id());
    EXPECT_TRUE(socket.send(answer.SerializeAsString()));
    answer.Clear();
    for (;;) {
      const BrowserSocket::Message message = socket.read();
      if (message.opcode != 2) return;
      v1::ServerMessage read;
      EXPECT_TRUE(read.ParseFromString(message.bytes));
      take(read, ages);
      answer.set_acknowledged_tick(read.tick());
      if (!socket.send(answer.SerializeAsString())) return;
    }
  }
  void watch(RawClient& client, Ages& ages) {
    while (!over_) {
      const v1::ServerMessage message = client.read();
      take(message, ages);
      if (!client.acknowledge(message.tick())) return;
    }
  }

  std::atomic<bool> crowded_ = false, over_ = false;
};

TEST_F(WebCrowdTest, OthersDoNotDelayTheFramesOfWatchers) {
  rlimit files{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &files), 0);
  files.rlim_cur = files.rlim_max;
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &files), 0);
  if (files.rlim_cur < 4 * kHalfOpen) GTEST_SKIP() << "needs " << 4 * kHalfOpen << " open files";
  server_->admit(kBrowsers + kNative);
  open();
  std::vector<Ages> ages(kBrowsers + kNative);
  std::vector<std::unique_ptr<RawClient>> native;
  for (size_t i = 0; i < kNative; ++i) {
    native.push_back(std::make_unique<RawClient>(server_->port()));
    const grpc::Status joined = native.back()->join();
    ASSERT_TRUE(joined.ok()) << i << ": " << joined.error_message();
    native.back()->open();
  }
  std::vector<std::jthread> watchers;
  for (size_t i = 0; i < ages.size(); ++i) {
    watchers.emplace_back([this, i, &ages, &native] {
      i < kBrowsers ? browse(ages[i]) : watch(*native[i - kBrowsers], ages[i]);
    });
  }
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (server_->streaming_count() < ages.size() && std::chrono::steady_clock::now() < until)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(server_->streaming_count(), ages.size());

  std::vector<std::unique_ptr<Wire>> crowd;
  size_t refused = 0;
  auto next = std::chrono::steady_clock::now();
  for (int tick = 1; tick <= kTicks; ++tick) {
    if ((tick - 1) % (kTicks / kRounds) == 0) {
      crowded_ = !crowded_.load();
      crowd.clear();
      if (crowded_) {
        for (size_t i = 0; i < kHalfOpen + kSlow; ++i)
          crowd.push_back(std::make_unique<Wire>(server_->port()));
      }
      next = std::chrono::steady_clock::now();
    }
    for (size_t i = kHalfOpen; i < crowd.size(); ++i) {  // a byte each
      constexpr std::string_view kRequest = "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nA: ";
      const size_t at = static_cast<size_t>(tick) % (kTicks / kRounds);
      if (!crowd[i]->send(std::string(1, at < kRequest.size() ? kRequest[at] : 'a'))) ++refused;
    }
    publish(static_cast<uint64_t>(tick));
    std::this_thread::sleep_until(next += kPeriod);
  }
  over_ = true;
  server_->shut_down("the test is over");
  watchers.clear();
  Ages all;
  for (const Ages& one : ages) {
    for (int phase = 0; phase < 2; ++phase) {
      EXPECT_GT(one.of_phase[phase].size(), static_cast<size_t>(kTicks) / 4) << "a client missed frames";
      all.of_phase[phase].insert(all.of_phase[phase].end(), one.of_phase[phase].begin(),
                                 one.of_phase[phase].end());
    }
  }
  const double quiet_ms = p99(all.of_phase[0]), crowded_ms = p99(all.of_phase[1]);
  std::printf("p99 of %zu and %zu frames: %.2f ms alone, %.2f ms in the crowd; %zu bytes refused\n",
              all.of_phase[0].size(), all.of_phase[1].size(), quiet_ms, crowded_ms, refused);
  EXPECT_LE(crowded_ms, kMaxRatio * quiet_ms + kSlack_ms);
  EXPECT_GT(refused, 0u) << "slow requests end";
}

}  // namespace
}  // namespace livegs
