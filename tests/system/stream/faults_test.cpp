// SPDX-License-Identifier: Apache-2.0
// Faults of the network, of other clients and of the server, and their effects on a client.
// tests/system/FAULTS.md lists all of them. timing_test.cpp measures their times.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <thread>

#include "common/gaussian/synthetic_asset.h"
#include "core/content_hash.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "server/session/rpc/raw_client.h"
#include "session/sessions/session_table.h"
#include "stream/received/asset_cache.h"
#include "system/stream/noise_server.h"
#include "system/support/connection_storm.h"
#include "system/support/counting_sink.h"
#include "system/support/proxied_session.h"

namespace livegs {
namespace {

class Faults : public ProxiedSession {};

// Only frames that were in flight are old after a stall; the next one is the newest.
TEST_F(Faults, NewestFrameFollowsAStall) {
  start();
  proxy_->stall(60);
  const uint64_t from = served_->tick;
  ASSERT_TRUE(wait_until([&] { return served_->tick >= from + 27; }));  // 300 ms of ticks
  const uint64_t newest = served_->tick;
  proxy_->stall(0);
  ASSERT_TRUE(sink_.wait([&](const SinkLog::State& state) { return state.frames.back().tick >= newest; }));
  const SinkLog::State state = sink_.state();
  expect_unbroken(state);
  expect_in_order(state.frames);
  // The window has at most four frames.
  const auto old = std::count_if(state.frames.begin(), state.frames.end(), [&](const ReceivedFrame& one) {
    return one.tick > from && one.tick + 2 < newest;
  });
  EXPECT_LE(old, 4);
}

// The fracture is described once, in order between frames, and the stream does not break. The stall begins
// one tick before the fracture and lasts kStall_ns after it, on machines of any speed. A machine that is too
// slow for one frame per second breaks the stream.
TEST_F(Faults, FractureDuringStallPrecedesItsFrames) {
  constexpr uint64_t kStallFrom = 359;        // the fracture is in tick 360
  constexpr int64_t kStall_ns = 300'000'000;  // shorter than the second after which a client reconnects
  struct Seen {
    std::atomic<FaultProxy*> proxy{nullptr};
    std::atomic<int64_t> stalled_ns{0}, broken_ns{0};
  };
  const auto seen = std::make_shared<Seen>();  // the server outlives this function
  start(breaking_scene(90, 1, 4), patient(), [seen](const Scene& scene) {
    const bool begins = scene.world().tick() == kStallFrom;
    const bool breaks = seen->broken_ns == 0 && scene.objects().back().rest.revision > 0;
    FaultProxy* const proxy = seen->proxy;
    if (begins) seen->stalled_ns = now_ns();
    if (breaks) seen->broken_ns = now_ns();
    if (proxy && (begins || breaks)) proxy->stall(seconds_from_ns(kStall_ns));
  });
  ASSERT_TRUE(client_);
  seen->proxy = proxy_.get();
  ASSERT_LT(served_->tick, kStallFrom) << "the stall began too late; the machine is overloaded";
  const auto broken = [](const ReceivedFrame& frame) { return frame.drivers->objects.back().revision > 0; };
  ASSERT_TRUE(sink_.wait([&](const SinkLog::State& state) { return broken(state.frames.back()); }));
  ASSERT_TRUE(sink_.wait_frames(20));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.added.empty() && state.removed.empty());
  expect_unbroken(state);
  const int64_t stalled_ns = seen->stalled_ns, broken_ns = seen->broken_ns;
  EXPECT_GT(broken_ns, stalled_ns);
  const auto first = std::find_if(state.frames.begin(), state.frames.end(), broken);
  EXPECT_GE(first->received_ns, broken_ns + kStall_ns);  // nothing passed during the stall
  EXPECT_TRUE(std::all_of(first, state.frames.end(), broken));
  const uint32_t revision = first->drivers->objects.back().revision;
  const auto is_it = [&](const StreamedObject& object) { return object.rest.revision == revision; };
  ASSERT_EQ(std::count_if(state.changed.begin(), state.changed.end(), is_it), 1);
  const auto change = std::find_if(state.changed.begin(), state.changed.end(), is_it) - state.changed.begin();
  EXPECT_LE(state.changed_at[static_cast<size_t>(change)], static_cast<size_t>(first - state.frames.begin()));
  std::printf(
      "fracture %.1f ms into a stall of %.0f ms after it; its first frame followed %.1f ms after the stall\n",
      milliseconds_from_ns(broken_ns - stalled_ns), milliseconds_from_ns(kStall_ns),
      milliseconds_from_ns(first->received_ns - broken_ns - kStall_ns));
}

TEST_F(Faults, JitterNeitherBreaksNorReordersStream) {
  start();
  proxy_->set_link({.delay_ms = 1, .jitter_ms = 40});
  const size_t begin = sink_.state().frames.size();
  ASSERT_TRUE(sink_.wait_frames(60));
  const SinkLog::State state = sink_.state();
  expect_unbroken(state);
  expect_in_order(state.frames);
  // 90 % of a uniform jitter of 40 ms are 36 ms. Keeping the byte order reduces the spread; other load
  // increases it.
  EXPECT_GE(spread_ms(std::span(state.frames).subspan(begin)), 20.0);
}

// Both ends use the same clock, so the true offset is 0. The link has 20 ms of jitter in each direction.
TEST_F(Faults, ClockErrorIsWithinUncertaintyUnderJitter) {
  start();
  proxy_->set_link({.delay_ms = 1, .jitter_ms = 20});
  ASSERT_TRUE(sink_.wait_frames(120));
  const SinkLog::State state = sink_.state();
  for (const ReceivedFrame& frame : std::span(state.frames).last(60)) {
    ASSERT_TRUE(frame.clock);
    EXPECT_LE(std::abs(frame.clock->offset_ns), frame.clock->uncertainty_ns);
    // The times along the path ascend.
    EXPECT_LE(frame.stepped_ns, frame.encode_begun_ns);
    EXPECT_LE(frame.encode_begun_ns, frame.sent_ns);
    EXPECT_LE(frame.sent_ns, frame.received_ns);
    EXPECT_LE(frame.received_ns, frame.decoded_ns);
  }
}

// A frame is sent when its tick is done, regardless of the duration of the tick.
TEST_F(Faults, SlowTickDelaysOnlyItsFrame) {
  constexpr int64_t kTakes_ns = 40'000'000;
  const auto slow = std::make_shared<std::atomic<bool>>(false);  // the server outlives this function
  start(box_scene(), patient(), [slow](const Scene&) {
    if (*slow) sleep_until_ns(now_ns() + kTakes_ns);
  });
  ASSERT_TRUE(client_);
  *slow = true;
  const uint64_t slow_from = served_->tick + 2;
  ASSERT_TRUE(
      sink_.wait([&](const SinkLog::State& state) { return state.frames.back().tick >= slow_from + 30; }));
  const SinkLog::State state = sink_.state();
  expect_unbroken(state);
  expect_in_order(state.frames);
  for (size_t i = 1; i < state.frames.size(); ++i) {
    const ReceivedFrame &before = state.frames[i - 1], &frame = state.frames[i];
    if (before.tick <= slow_from) continue;
    // The step ends before the observer sleeps, so each frame is at least as old as the sleep.
    EXPECT_GE(frame.received_ns - frame.stepped_ns, kTakes_ns);
    EXPECT_GE(frame.stepped_ns - before.stepped_ns, kTakes_ns);
  }
}

// 16 kB frames at 90 Hz need 11.5 Mbit/s. At 2 Mbit/s, one frame takes 64 ms, so most frames are dropped,
// also on a slow machine.
TEST(NarrowPipe, DropsFramesInsteadOfQueueing) {
  NoiseServer noise(2667);
  FaultProxy proxy(noise.port());
  SinkLog sink;
  const auto client = join(proxy.port());
  ASSERT_TRUE(client);
  proxy.set_link({.delay_ms = 1, .mbit_s = 2});
  client->start(sink);
  ASSERT_TRUE(sink.wait_frames(50));
  EXPECT_TRUE(client->stop());
  const SinkLog::State state = sink.state();
  expect_unbroken(state);
  expect_in_order(state.frames);
  EXPECT_GT(state.frames.back().bytes, 15'000u);
  const auto later = std::span(state.frames).last(30);
  EXPECT_GT(later.back().tick - later.front().tick, 45u);  // the others were dropped
}

size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  size_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<size_t>(::sysconf(_SC_PAGESIZE));
}

// One of four clients stops reading. A server that queued 135 frames of 54 kB for it would hold 7 MB. A fifth
// client never acknowledges and is disconnected.
TEST(SlowClient, DelaysNoOtherAndUsesNoMemory) {
  NoiseServer noise(9000);
  std::vector<std::unique_ptr<CountingSink>> sinks;
  std::vector<std::unique_ptr<SessionClient>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(join(noise.port()));
    ASSERT_TRUE(clients.back());
    sinks.push_back(std::make_unique<CountingSink>());
    clients.back()->start(*sinks.back());
  }
  const auto got = [&](size_t client, uint64_t frames) {
    return wait_until([&] { return sinks[client]->frames >= frames; });
  };
  for (size_t i = 0; i < 4; ++i) ASSERT_TRUE(got(i, 50));
  sinks[3]->freeze(true);
  ASSERT_TRUE(got(0, sinks[0]->frames + 10));
  const uint64_t frozen_at = sinks[3]->frames, others_at = sinks[0]->frames;
  const size_t before = resident_bytes();
  const uint64_t tick = noise.newest;
  ASSERT_TRUE(wait_until([&] { return noise.newest >= tick + 135; }));
  const double grown_mb = 1e-6 * (static_cast<double>(resident_bytes()) - static_cast<double>(before));
  EXPECT_LT(grown_mb, 5.0);
  EXPECT_TRUE(got(0, others_at + 40));
  EXPECT_LE(sinks[3]->frames, frozen_at + 1);  // one may have been on its way
  // The threads of the frozen client still acknowledge, so it stays connected and receives frames again.
  sinks[3]->freeze(false);
  EXPECT_TRUE(got(3, frozen_at + 5));

  RawClient still(noise.port());
  ASSERT_TRUE(still.join().ok());
  still.open();
  v1::ServerMessage first;
  ASSERT_TRUE(still.read_any(first));
  EXPECT_TRUE(wait_until([&] { return noise.server->streaming_count() == 4; }));
  for (size_t i = 0; i < 4; ++i) EXPECT_TRUE(got(i, sinks[i]->frames + 5));
  EXPECT_FALSE(still.finish_reading().ok());
  for (auto& client : clients) EXPECT_TRUE(client->stop());
}

// An environment of incompressible noise, about 700 kB.
Scene scene_with_a_room(const ScratchFolder& folder) {
  const auto written = write_asset(folder.path() / "room.ply", synthetic_asset(8000, 1, 3));
  EXPECT_TRUE(written) << written.error().message;
  v1::Scene file;
  file.mutable_environment()->set_asset("room.ply");
  file.mutable_environment()->add_colliders()->mutable_plane();
  auto scene = Scene::build(file, folder.path(), "room", {});
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

TEST_F(Faults, InterruptedAssetResumesAtItsOffset) {
  const ScratchFolder folder;
  start(scene_with_a_room(folder));
  const StreamedObject& room = client_->scene().objects.at(0);
  const AssetCache cache(folder / "cache");
  size_t pieces = 0;
  std::vector<uint64_t> begun_at;
  std::vector<size_t> kernels;  // kernels that could be drawn
  // Slow enough that the client reads all arrived bytes on a busy machine; a reset discards unread bytes.
  proxy_->set_link({.mbit_s = 10});
  const uint64_t before = proxy_->bytes_from_server();
  proxy_->reset_after(room.asset_bytes * 6 / 10, 1);
  const auto obtained = cache.obtain(
      room.asset_hash, room.asset_bytes,
      [&](uint64_t begin, const TakeChunk& take) {
        begun_at.push_back(begin);
        return client_->fetch_asset(room.asset_hash, room.asset_bytes, begin,
                                    [&](uint64_t offset, uint64_t total, std::span<const std::byte> piece) {
                                      ++pieces;
                                      return take(offset, total, piece);
                                    });
      },
      [&](const ProgressiveDecoder& so_far) { kernels.push_back(so_far.arrived()); });
  ASSERT_TRUE(obtained) << obtained.error().message;
  EXPECT_EQ(obtained->fetched_bytes, room.asset_bytes);
  EXPECT_EQ(content_hash(obtained->bytes), room.asset_hash);
  EXPECT_EQ(begun_at, (std::vector<uint64_t>{0}));  // the client resumes the transfer internally
  EXPECT_GT(pieces, 1u);
  // The asset was drawable at low detail before it was complete.
  ASSERT_GE(kernels.size(), 3u);
  EXPECT_LT(kernels.front(), 8000u);
  EXPECT_EQ(kernels.back(), 8000u);
  EXPECT_LT(room.asset_bytes, obtained->bytes.size());
  // The asset was sent once, plus the part of a piece in flight (pipe 128 kB, piece 64 kB) and some frames.
  const uint64_t brought = proxy_->bytes_from_server() - before;
  EXPECT_LT(brought, room.asset_bytes + (256u << 10)) << room.asset_bytes;
  expect_unbroken(sink_.state());  // the stream uses its own connection
}

TEST_F(Faults, ReplacedAssetIsReportedAfterRestart) {
  start();
  const JoinedScene& joined = client_->scene();
  proxy_->set_server(kNobody);
  proxy_->reset();
  ASSERT_TRUE(sink_.wait([](const SinkLog::State& state) { return !state.lost.empty(); }));
  served_ = std::make_unique<ServedScene>(box_scene(90, 0.25));
  proxy_->set_server(served_->port());
  ASSERT_TRUE(sink_.wait_resumed(1));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.changed.empty() && state.removed.empty());
  const auto box = std::find_if(state.added.begin(), state.added.end(),
                                [](const StreamedObject& object) { return object.name == "box"; });
  ASSERT_NE(box, state.added.end());
  EXPECT_EQ(box->id, joined.objects.at(1).id);
  EXPECT_NE(box->asset_hash, joined.objects.at(1).asset_hash);
  // The size of the floor follows the scene; the cube is unchanged.
  for (const StreamedObject& object : state.added)
    EXPECT_TRUE(object.name == "box" || object.environment) << object.name;
}

// Connections that close after sending nothing or invalid data, and more sessions that join and leave than
// the server has slots.
TEST_F(Faults, ShortConnectionsDoNotDisturbASession) {
  start();
  const size_t before = sink_.state().frames.size();
  (void)connection_storm(served_->port(), 1000);
  EXPECT_GT(sink_.state().frames.size(), before);
  ASSERT_TRUE(sink_.wait_frames(10));
  expect_unbroken(sink_.state());
  EXPECT_GT(served_->server->sessions().sessions, kDefaultSessions);
  SinkLog late;
  const auto other = join(served_->port());
  ASSERT_TRUE(other);
  other->start(late);
  EXPECT_TRUE(late.wait_frames(5));
  EXPECT_TRUE(other->stop());
}

}  // namespace
}  // namespace livegs
