// SPDX-License-Identifier: Apache-2.0
// As many clients as a server takes unless it is told otherwise, all of which read. How old their frames are is `stream_bench`'s to
// tell, on a machine that does nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "server/session/rpc/raw_client.h"
#include "system/stream/noise_server.h"

namespace livegs {
namespace {

// Reads and acknowledges, and decodes nothing: that would be other machines' work.
class Listener {
 public:
  explicit Listener(int port) : raw_(port) {
    const grpc::Status status = raw_.join();
    EXPECT_TRUE(status.ok()) << status.error_message();
    raw_.open();
    thread_ = std::thread([this] {
      v1::ServerMessage message;
      while (raw_.read_any(message)) {
        if (message.tick() == 0) continue;
        tick_ = message.tick();
        ++frames_;
        raw_.acknowledge(message.tick());
      }
    });
  }
  ~Listener() {
    raw_.cancel();
    thread_.join();
    (void)raw_.finish_reading();
  }
  uint64_t tick() const { return tick_; }
  uint64_t frames() const { return frames_; }

 private:
  RawClient raw_;
  std::atomic<uint64_t> tick_{0}, frames_{0};
  std::thread thread_;
};

TEST(ManyClients, SixtyFourGetTheirFramesAndShareTheirBytes) {
  NoiseServer noise(1000);
  std::vector<std::unique_ptr<Listener>> clients;
  for (size_t i = 0; i < kUsualSessions; ++i) clients.push_back(std::make_unique<Listener>(noise.port()));
  const auto wait = [&](const std::function<bool(const Listener&)>& enough) {
    const int64_t until_ns = now_ns() + std::chrono::nanoseconds(kPatience).count();
    const auto all = [&] { return std::all_of(clients.begin(), clients.end(), [&](const auto& client) { return enough(*client); }); };
    while (!all() && now_ns() < until_ns) sleep_until_ns(now_ns() + 5'000'000);
    return all();
  };
  ASSERT_TRUE(wait([](const Listener& client) { return client.frames() >= 20; }));
  EXPECT_EQ(RawClient(noise.port()).join().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);

  const uint64_t tick = noise.newest;
  const PublisherSummary before = noise.server->published();
  std::vector<uint64_t> got;
  for (const auto& client : clients) got.push_back(client->frames());
  while (noise.newest < tick + 180) sleep_until_ns(now_ns() + 5'000'000);
  const PublisherSummary after = noise.server->published();
  const double made = static_cast<double>(noise.newest - tick);
  for (size_t i = 0; i < clients.size(); ++i) got[i] = clients[i]->frames() - got[i];
  std::sort(got.begin(), got.end());
  const double encodings = static_cast<double>(after.encoded - before.encoded) / static_cast<double>(after.frames - before.frames);
  std::printf("of %.0f ticks the last of %zu clients got %.2f, half of them %.2f or more; a tick was encoded %.1f times\n", made, clients.size(),
              static_cast<double>(got.front()) / made, static_cast<double>(got[got.size() / 2]) / made, encodings);
  // Nobody is left behind, whatever the machine can do: none has less than half of what half of them have.
  EXPECT_GE(got.front() * 2, got[got.size() / 2]);
  EXPECT_GT(got.front(), 0u);
  // Each by itself would be 64.
  EXPECT_LT(encodings, 16.0);
  const uint64_t newest = noise.newest;
  EXPECT_TRUE(wait([&](const Listener& client) { return client.tick() >= newest; }));
  EXPECT_EQ(noise.server->streaming_count(), kUsualSessions);
}

}  // namespace
}  // namespace livegs
