// SPDX-License-Identifier: Apache-2.0
// The default maximum number of clients, all reading. `stream_bench` measures the age of their frames.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "system/stream/noise_server.h"
#include "system/support/listener.h"
#include "system/support/proxied_session.h"

namespace livegs {
namespace {

TEST(ManyClients, SixtyFourShareOneEncodingPerTick) {
  NoiseServer noise(1000);
  std::vector<std::unique_ptr<Listener>> clients;
  for (size_t i = 0; i < kDefaultSessions; ++i) clients.push_back(std::make_unique<Listener>(noise.port()));
  const auto wait = [&](const std::function<bool(const Listener&)>& enough) {
    return wait_until([&] {
      return std::all_of(clients.begin(), clients.end(), [&](const auto& client) { return enough(*client); });
    });
  };
  ASSERT_TRUE(wait([](const Listener& client) { return client.frames() >= 20; }));
  EXPECT_EQ(RawClient(noise.port()).join().error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  const PublisherSummary before = noise.server->published();
  ASSERT_TRUE(wait([](const Listener& client) { return client.frames() >= 50; }))
      << "a client received too few frames";
  const PublisherSummary after = noise.server->published();
  // Separate encodings would be 64 per tick.
  EXPECT_LT(static_cast<double>(after.encoded - before.encoded),
            32.0 * static_cast<double>(after.frames - before.frames));
  const uint64_t newest = noise.newest;
  EXPECT_TRUE(wait([&](const Listener& client) { return client.tick() >= newest; }));
  EXPECT_EQ(noise.server->streaming_count(), kDefaultSessions);
}

}  // namespace
}  // namespace livegs
