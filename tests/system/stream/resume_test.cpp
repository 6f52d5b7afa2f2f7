// SPDX-License-Identifier: Apache-2.0
// Reconnection of a client after faults of its network or server.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <thread>

#include "scratch_folder.h"
#include "stream/channel/retry_schedule.h"
#include "system/support/proxied_session.h"
#include "viewer/runs/offscreen_run.h"

namespace livegs {
namespace {

class Resume : public ProxiedSession {};

TEST_F(Resume, ResetConnectionKeepsSessionAndScene) {
  start();
  proxy_->reset();
  ASSERT_TRUE(sink_.wait_resumed(1));
  ASSERT_TRUE(sink_.wait_frames(5));
  EXPECT_TRUE(client_->stop());
  const SinkLog::State state = sink_.state();
  EXPECT_EQ(state.lost.size(), 1u);
  EXPECT_TRUE(state.resumed.front().same_server);
  EXPECT_TRUE(state.added.empty() && state.changed.empty() && state.removed.empty());
  for (size_t i = 1; i < state.frames.size(); ++i) EXPECT_GT(state.frames[i].tick, state.frames[i - 1].tick);
  EXPECT_EQ(served_->server->sessions().sessions, 1u);  // the existing session was resumed
}

// Neither end is notified of a cut. Client and server detect the silence and give up the stream. The client
// then opens connections until one of them receives frames.
TEST_F(Resume, SameSessionContinuesAfterACut) {
  start();
  const uint64_t before = proxy_->connections();
  proxy_->cut();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  EXPECT_TRUE(wait_until([&] { return served_->server->streaming_count() == 0; }));
  EXPECT_TRUE(wait_until([&] { return proxy_->connections() >= before + 10; }));
  proxy_->heal();
  ASSERT_TRUE(sink_.wait_resumed(1));
  ASSERT_TRUE(sink_.wait_frames(20));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.resumed.front().same_server);
  EXPECT_TRUE(state.added.empty() && state.changed.empty() && state.removed.empty());
  EXPECT_TRUE(client_->stop());
  EXPECT_EQ(served_->server->sessions().sessions, 1u);
}

TEST_F(Resume, ClientBetweenTwoStreamsMovesToTheNextServer) {
  start();
  ServedScene next(box_scene());
  proxy_->cut();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  ASSERT_TRUE(wait_until([&] { return served_->server->streaming_count() == 0; }));
  std::jthread ends([&] {
    served_->server->shut_down("the node is drained", {"127.0.0.1:" + std::to_string(next.port()), ""});
  });
  ASSERT_TRUE(wait_until([&] { return !served_->server->session_table().status().open; }));
  proxy_->heal();
  ASSERT_TRUE(sink_.wait_resumed(2));
  EXPECT_FALSE(sink_.state().resumed.back().same_server);
  EXPECT_TRUE(sink_.wait_frames(5));
  EXPECT_EQ(next.server->streaming_count(), 1u);
  EXPECT_TRUE(client_->stop());
}

// A frame in flight may take longer than the second of silence after which a client gives up.
TEST(NarrowLink, ShowsKernelFramesThatTakeSeconds) {
  ServedScene served(box_scene());
  FaultProxy proxy(served.port());
  ConnectOptions options;
  options.timeout_s = options.reconnect_s = 60;
  options.encoding = v1::JoinRequest::KERNELS;
  const auto join = [&] { return SessionClient::join("127.0.0.1:" + std::to_string(proxy.port()), options); };
  size_t bytes = 0;
  {
    SinkLog sink;
    auto client = join();
    ASSERT_TRUE(client) << client.error().message;
    (*client)->start(sink);
    ASSERT_TRUE(sink.wait_frames(1));
    EXPECT_TRUE((*client)->stop());
    bytes = sink.state().frames.front().bytes;
  }
  SinkLog sink;
  auto client = join();
  ASSERT_TRUE(client) << client.error().message;
  proxy.set_link({.mbit_s = 8e-6 * static_cast<double>(bytes) / 2.5});
  const int64_t begun_ns = now_ns();
  (*client)->start(sink);
  EXPECT_TRUE(sink.wait_frames(3));
  EXPECT_TRUE((*client)->stop());
  const SinkLog::State state = sink.state();
  EXPECT_TRUE(state.lost.empty()) << state.lost.front();
  ASSERT_FALSE(state.frames.empty());
  EXPECT_GT(seconds_from_ns(state.frames.front().received_ns - begun_ns), 1.5);
}

TEST(RetrySchedule, PausesAreWithinTheirBounds) {
  for (int64_t outage_s = 0; outage_s < 3600; ++outage_s) {
    int64_t least_ns = kLongRetryPause_ns, most_ns = 0;
    for (uint32_t random = 0; random < 4096; ++random) {
      const int64_t pause_ns = retry_pause_ns(outage_s * 1'000'000'000, random * 2654435761u);
      least_ns = std::min(least_ns, pause_ns);
      most_ns = std::max(most_ns, pause_ns);
    }
    // Half of the 300 ms after a cut, and most of the 500 ms after a server restart.
    EXPECT_LE(most_ns, outage_s < 60 ? 150'000'000 : 400'000'000);
    EXPECT_LT(least_ns, most_ns * 0.81);  // retries of several clients are not synchronised
    EXPECT_GE(least_ns, most_ns * 0.79);
  }
}

// A stopped server, as a client sees it: connections are reset, and new ones are refused.
TEST_F(Resume, RestartedServerHasTheSameScene) {
  start();
  proxy_->set_server(kNobody);
  proxy_->reset();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  served_ = std::make_unique<ServedScene>(box_scene());
  proxy_->set_server(served_->port());
  ASSERT_TRUE(sink_.wait_resumed(1));
  ASSERT_TRUE(sink_.wait_frames(20));
  EXPECT_TRUE(client_->stop());
  const SinkLog::State state = sink_.state();
  EXPECT_FALSE(state.resumed.back().same_server);
  EXPECT_TRUE(state.added.empty() && state.changed.empty() && state.removed.empty());
  const ReceivedFrame &before = state.frames.front(), &after = state.frames.back();
  ASSERT_EQ(before.drivers->objects.size(), after.drivers->objects.size());
  for (size_t i = 0; i < before.drivers->objects.size(); ++i) {
    EXPECT_EQ(before.drivers->objects[i].object_id, after.drivers->objects[i].object_id);
  }
}

TEST_F(Resume, ChangesInOutagePrecedeTheNextFrame) {
  start(breaking_scene(), patient());
  proxy_->cut();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  while (served_->tick < 120)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));  // the break is in tick 90
  proxy_->heal();
  ASSERT_TRUE(sink_.wait_resumed(1));
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) {
    return !state.changed.empty() && state.frames.back().drivers->objects.back().revision > 0;
  }));
  EXPECT_TRUE(client_->stop());
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.added.empty() && state.removed.empty());
  const uint32_t revision = state.frames.back().drivers->objects.back().revision;
  EXPECT_TRUE(std::any_of(state.changed.begin(), state.changed.end(),
                          [&](const StreamedObject& object) { return object.rest.revision == revision; }));
}

TEST_F(Resume, LongOutageEndsTheSessionInTime) {
  ConnectOptions options = patient();
  options.reconnect_s = 3;
  start(box_scene(), options);
  const int64_t reset_ns = now_ns();
  proxy_->set_server(kNobody);
  proxy_->reset();
  while (!client_->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  // Counted from the last message, which a scene at rest sends less often.
  EXPECT_GE(seconds_from_ns(now_ns() - reset_ns), 2.0);
  const auto stopped = client_->stop();
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::Unavailable);
  EXPECT_NE(stopped.error().message.find("connection lost"), std::string::npos) << stopped.error().message;
}

TEST_F(Resume, DrainEndsTheSessionByDefault) {
  start();
  served_->server->shut_down("maintenance");
  while (!client_->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_TRUE(client_->stop());
  EXPECT_EQ(sink_.state().draining, "maintenance");
  EXPECT_TRUE(sink_.state().lost.empty());
}

TEST_F(Resume, ReconnectsAfterDrainIfRequested) {
  ConnectOptions options = patient();
  options.reconnect_after_drain = true;
  start(box_scene(), options);
  served_->server->shut_down("maintenance");
  served_ = std::make_unique<ServedScene>(box_scene());
  proxy_->set_server(served_->port());
  ASSERT_TRUE(sink_.wait_resumed(1));
  EXPECT_TRUE(client_->stop());
  EXPECT_EQ(sink_.state().draining, "maintenance");
}

// Both servers are on this machine, without TLS.
TEST_F(Resume, FollowsADrainingServerToTheNextOne) {
  start();
  const ServedScene next(box_scene());
  const std::string address = "127.0.0.1:" + std::to_string(next.port());
  served_->server->shut_down("maintenance", {address, ""});
  ASSERT_TRUE(sink_.wait_resumed(1));
  served_.reset();
  const size_t frames = sink_.state().frames.size();
  ASSERT_TRUE(sink_.wait_frames(frames + 20));
  EXPECT_EQ(client_->place()->now().address, address);
  EXPECT_EQ(next.server->streaming_count(), 1u);
  EXPECT_EQ(sink_.state().moving, "maintenance to " + address);
  EXPECT_EQ(sink_.state().draining, "");
  EXPECT_FALSE(sink_.state().resumed.back().same_server);
  const StreamedObject& box = client_->scene().objects.back();
  size_t bytes = 0;
  const auto fetched =
      client_->fetch_asset(box.asset_hash, box.asset_bytes, 0,
                           [&](uint64_t, uint64_t, std::span<const std::byte> chunk) -> Result<void> {
                             bytes += chunk.size();
                             return {};
                           });
  EXPECT_TRUE(fetched) << fetched.error().message;
  EXPECT_EQ(bytes, box.asset_bytes);
  EXPECT_TRUE(client_->stop());
}

TEST_F(Resume, FollowsToOtherMachinesOverTlsOnly) {
  start();
  served_->server->shut_down("maintenance", {"192.0.2.1:9780", ""});
  while (!client_->ended()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const auto stopped = client_->stop();
  ASSERT_FALSE(stopped);
  EXPECT_NE(stopped.error().message.find("192.0.2.1:9780 needs TLS"), std::string::npos)
      << stopped.error().message;
}

// The offscreen client during a restart that changes some objects. The last picture stays until the first
// frame of the new server. New assets are fetched and drawn, and video time continues.
TEST(OffscreenRun, ContinuesAfterServerRestart) {
  auto served = std::make_unique<ServedScene>(box_scene());
  FaultProxy proxy(served->port());
  const ScratchFolder folder;
  OffscreenRunOptions run;
  run.address = "127.0.0.1:" + std::to_string(proxy.port());
  run.seconds = 0;
  run.output = folder / "view";
  run.cache = folder / "cache";
  run.size = PictureSize{64, 48};
  run.video = false;
  run.png_every = 1;  // draws every picture
  run.renderer = RendererChoice::Cpu;
  run.connect_timeout_s = run.reconnect_s = 60;
  std::atomic<bool> interrupted{false};
  Result<OffscreenRunSummary> summary = Error{};
  std::thread client([&] { summary = run_offscreen(run, interrupted); });
  const auto pictures_drawn = [&] {
    std::error_code ignored;
    const std::filesystem::directory_iterator files(run.output, ignored);
    return std::count_if(begin(files), end(files),
                         [](const auto& one) { return one.path().extension() == ".png"; });
  };
  EXPECT_TRUE(wait_until([&] { return pictures_drawn() > 0; }));
  proxy.set_server(kNobody);
  proxy.reset();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const auto before = pictures_drawn();
  served = std::make_unique<ServedScene>(box_scene(90, 0.25));
  proxy.set_server(served->port());
  EXPECT_TRUE(wait_until([&] { return served->server->streaming_count() > 0; }));
  EXPECT_TRUE(wait_until([&] { return pictures_drawn() > before + 10; }));
  interrupted = true;
  client.join();
  ASSERT_TRUE(summary) << summary.error().message;
  EXPECT_FALSE(summary->stream_error) << summary->stream_error->message;
  EXPECT_EQ(summary->outages.count, 1u);
  EXPECT_EQ(summary->outages.resumed, 1u);
  EXPECT_EQ(summary->outages.restarted, 1u);
  EXPECT_GT(summary->outages.seconds, 0);
  EXPECT_EQ(summary->assets.assets,
            5u);  // three initially, then a different box and floor; the cube is unchanged
  EXPECT_NE(summary_text(*summary).find("1 disconnect, 1 reconnect after"), std::string::npos)
      << summary_text(*summary);
  std::ifstream file(run.output / "timings.csv");
  std::string line;
  std::getline(file, line);
  size_t pictures = 0;
  while (std::getline(file, line)) ++pictures;
  // 30 pictures per second of the whole time, including the outage.
  EXPECT_GE(static_cast<double>(pictures), 30 * summary->outages.seconds);
}

}  // namespace
}  // namespace livegs
