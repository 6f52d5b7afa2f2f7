// SPDX-License-Identifier: Apache-2.0
// Frames for clients with little bandwidth and for clients that look away, over the wire.
#include <gtest/gtest.h>

#include <algorithm>

#include "session/frames/send_budget.h"
#include "system/stream/noise_server.h"
#include "system/support/proxied_session.h"

namespace livegs {
namespace {

std::unique_ptr<SessionClient> join(int port, double max_mbit_s) {
  ConnectOptions options = patient();
  options.max_mbit_s = max_mbit_s;
  return livegs::join(port, options);
}

// Bytes of all frames except the last, and the time in which the server sent them.
struct Sent {
  double bytes = 0, seconds = 0;
};
Sent sent_in(const std::vector<ReceivedFrame>& frames) {
  Sent sent;
  for (size_t i = 0; i + 1 < frames.size(); ++i) sent.bytes += static_cast<double>(frames[i].bytes);
  sent.seconds = seconds_from_ns(frames.back().sent_ns - frames.front().sent_ns);
  return sent;
}

// 16 kB frames at 90 Hz need 11.5 Mbit/s. One client requests a cap of 4; the server's cap of 6 applies to
// all clients.
TEST(Sending, BandwidthStaysUnderTheCap) {
  NoiseServer noise(2667);
  noise.server->cap_clients(6);
  SinkLog modest_sink, greedy_sink;
  const auto modest = join(noise.port(), 4), greedy = join(noise.port(), 1000);
  ASSERT_TRUE(modest && greedy);
  modest->start(modest_sink);
  greedy->start(greedy_sink);
  const auto full = [](const SinkLog::State& state) {
    return std::count_if(state.frames.begin(), state.frames.end(),
                         [](const auto& one) { return one.bytes > 10'000; }) >= 60;
  };
  ASSERT_TRUE(modest_sink.wait(full) && greedy_sink.wait(full));
  // The burst that the budget saves, and the delay between the budget's decision and the time stamp on a busy
  // machine.
  constexpr double kSlack_s = SendBudget::kBurst_s + 0.3;
  for (const auto& [sink, mbit_s] : {std::pair{&modest_sink, 4.0}, {&greedy_sink, 6.0}}) {
    const SinkLog::State state = sink->state();
    const Sent sent = sent_in(state.frames);
    EXPECT_LE(8e-6 * sent.bytes, mbit_s * (sent.seconds + kSlack_s)) << mbit_s << " Mbit/s";
  }
  // With one object, dropped data are whole frames. Frames that arrive are fresh.
  expect_unbroken(modest_sink.state());
  EXPECT_TRUE(modest->stop());
  EXPECT_TRUE(greedy->stop());
}

// A client without congestion shares its encoding with all others. In 30 frames, the server does not classify
// it as slow on a busy machine.
TEST(Sending, UncongestedClientGetsUnseenObjects) {
  NoiseServer noise(2667);
  SinkLog sink;
  const auto client = join(noise.port(), 0);
  ASSERT_TRUE(client);
  client->set_view({{0, 0, 500}, {0, 0, 1}, 0.7});
  client->start(sink);
  ASSERT_TRUE(sink.wait_frames(30));
  const SinkLog::State state = sink.state();
  for (size_t i = 0; i < 30; ++i) EXPECT_GT(state.frames[i].bytes, 10'000u) << i;
  EXPECT_TRUE(client->stop());
}

// A link of 4 Mbit/s without a cap, for 11.5 Mbit/s of frames. Once congestion is detected, frames arrive
// every tick without the objects outside the view.
TEST(Sending, CongestedClientGetsNoUnseenObjects) {
  NoiseServer noise(2667);
  FaultProxy proxy(noise.port());
  proxy.set_link({.delay_ms = 1, .mbit_s = 4});
  SinkLog sink;
  const auto client = join(proxy.port(), 0);
  ASSERT_TRUE(client);
  client->set_view({{0, 0, 500}, {0, 0, 1}, 0.7});
  client->start(sink);
  ASSERT_TRUE(sink.wait([](const SinkLog::State& state) {
    return state.frames.size() > 1 && state.frames.back().bytes < 100;
  }));
  const size_t from = sink.state().frames.size();
  ASSERT_TRUE(sink.wait_frames(90));
  const SinkLog::State state = sink.state();
  size_t full = 0;
  for (size_t i = from; i < state.frames.size(); ++i) full += state.frames[i].bytes > 10'000 ? 1 : 0;
  EXPECT_LE(static_cast<double>(full),
            static_cast<double>(state.frames.back().tick - state.frames[from].tick) / 9 + 2);
  expect_unbroken(state);
  EXPECT_TRUE(client->stop());
}

// The noise object is within 0.5 m of the origin and has the id of the floor, which is several metres wide.
// The cap is never reached, but a capped client only receives useful objects.
TEST(Sending, CappedClientGetsOnlyWhatItLooksAt) {
  NoiseServer noise(2667);
  SinkLog sink;
  const auto client = join(noise.port(), 1000);
  ASSERT_TRUE(client);
  client->set_view({{0, 0, 500}, {0, 0, 1}, 0.7});
  client->start(sink);
  ASSERT_TRUE(sink.wait_frames(20));
  // Until the server has received the view, frames are complete. Afterwards one frame in nine contains the
  // noise.
  ASSERT_TRUE(sink.wait([](const SinkLog::State& state) { return state.frames.back().bytes < 100; }));
  const size_t away_from = sink.state().frames.size();
  ASSERT_TRUE(sink.wait_frames(90));
  SinkLog::State state = sink.state();
  size_t full = 0, frames = 0;
  for (size_t i = away_from; i < state.frames.size(); ++i, ++frames)
    full += state.frames[i].bytes > 10'000 ? 1 : 0;
  const double ticks = static_cast<double>(state.frames.back().tick - state.frames[away_from].tick);
  EXPECT_LE(static_cast<double>(full), ticks / 9 + 2);
  EXPECT_GE(static_cast<double>(full), static_cast<double>(frames) / 9 - 2);
  client->set_view({{0, 0, 500}, {0, 0, -1}, 0.7});
  // Two successive complete frames: the object is in view.
  ASSERT_TRUE(sink.wait([&](const SinkLog::State& now) {
    const size_t count = now.frames.size();
    return count > state.frames.size() + 2 && now.frames[count - 1].bytes > 10'000 &&
           now.frames[count - 2].bytes > 10'000;
  }));
  state = sink.state();
  const size_t back_from = state.frames.size();
  ASSERT_TRUE(sink.wait_frames(20));
  state = sink.state();
  for (size_t i = back_from; i < state.frames.size(); ++i) EXPECT_GT(state.frames[i].bytes, 10'000u);
  expect_unbroken(state);  // all hashes matched
  EXPECT_TRUE(client->stop());
}

}  // namespace
}  // namespace livegs
