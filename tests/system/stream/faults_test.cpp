// SPDX-License-Identifier: Apache-2.0
// Faults of the network, of other clients and of the server, and what a client sees of them. tests/system/FAULTS.md lists
// all of them.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <thread>

#include "client/stream/session/sink_log.h"
#include "common/gaussian/synthetic_asset.h"
#include "core/clock.h"
#include "core/content_hash.h"
#include "core/percentile.h"
#include "gaussian/asset_file.h"
#include "scratch_folder.h"
#include "server/session/rpc/raw_client.h"
#include "session/sessions/session_table.h"
#include "stream/received/asset_cache.h"
#include "stream/session/session_client.h"
#include "system/support/fault_proxy.h"
#include "system/join_server.h"
#include "system/support/lateness.h"
#include "system/stream/noise_server.h"
#include "scenes/served_scene.h"

namespace livegs {
namespace {

// The age of each frame when it came, on one machine, ms.
std::vector<double> ages_ms(std::span<const ReceivedFrame> frames) {
  std::vector<double> ages;
  for (const ReceivedFrame& frame : frames) ages.push_back(milliseconds_from_ns(frame.received_ns - frame.stepped_ns));
  return ages;
}

// By how much ages differ, without the twentieth at either end.
double spread_ms(std::span<const ReceivedFrame> frames) {
  const std::vector<double> ages = ages_ms(frames);
  return percentile(ages, 0.95) - percentile(ages, 0.05);
}

class Faults : public ::testing::Test {
 protected:
  void start(Scene scene, std::function<void(const Scene&)> observe = {}) {
    served_ = std::make_unique<ServedScene>(std::move(scene), std::move(observe));
    proxy_ = std::make_unique<FaultProxy>(served_->port());
    client_ = join(proxy_->port());
    ASSERT_TRUE(client_);
    client_->start(sink_);
    ASSERT_TRUE(sink_.wait_frames(5));
  }
  ~Faults() override { client_.reset(); }

  std::unique_ptr<ServedScene> served_;
  std::unique_ptr<FaultProxy> proxy_;
  SinkLog sink_;
  std::unique_ptr<SessionClient> client_;
};

// No more than the two frames that were under way on this link are old; then comes the newest.
TEST_F(Faults, After300MsOfStallTheThirdFrameIsFresh) {
  start(box_scene());
  const int64_t begun_ns = now_ns();
  proxy_->stall(0.3);
  sleep_until_ns(begun_ns + 290'000'000);
  const uint64_t newest = served_->tick;
  ASSERT_TRUE(sink_.wait([&](const SinkLog::State& state) { return state.frames.back().tick >= newest; }));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.lost.empty());
  size_t old = 0;
  for (const ReceivedFrame& frame : state.frames) {
    old += frame.received_ns > begun_ns + 295'000'000 && frame.tick + 2 < newest ? 1 : 0;
  }
  EXPECT_LE(old, 2u);
  EXPECT_GT(newest, state.frames.front().tick + 10);
  // It did stall: nothing came for that long, less the frame that was on its way out of the proxy.
  double gap_ms = 0;
  for (size_t i = 1; i < state.frames.size(); ++i)
    gap_ms = std::max(gap_ms, milliseconds_from_ns(state.frames[i].received_ns - state.frames[i - 1].received_ns));
  std::printf("a stall of 300 ms: no frame for %.0f ms, then %zu old ones\n", gap_ms, old);
  EXPECT_GE(gap_ms, 250.0);
}

// Told once, in its place between frames; and the session never knew of the stall, which begins a tick before it breaks and lasts for
// kStall_ns after, however slow the machine is; one that is so slow that nothing comes for a second ends the stream by itself.
TEST_F(Faults, WhatBreaksDuringAStallIsToldBeforeItsFirstFrame) {
  constexpr uint64_t kStallFrom = 359;        // it breaks at 360
  constexpr int64_t kStall_ns = 300'000'000;  // less than the second after which a client gives up
  struct Seen {
    std::atomic<FaultProxy*> proxy{nullptr};
    std::atomic<int64_t> stalled_ns{0}, broken_ns{0};
  };
  const auto seen = std::make_shared<Seen>();  // the server outlives this body
  start(breaking_scene(90, 1, 4), [seen](const Scene& scene) {
    const bool begins = scene.world().tick() == kStallFrom;
    const bool breaks = seen->broken_ns == 0 && scene.objects().back().rest.revision > 0;
    FaultProxy* const proxy = seen->proxy;
    if (begins) seen->stalled_ns = now_ns();
    if (breaks) seen->broken_ns = now_ns();
    if (proxy && (begins || breaks)) proxy->stall(seconds_from_ns(kStall_ns));
  });
  ASSERT_TRUE(client_);
  seen->proxy = proxy_.get();
  ASSERT_LT(served_->tick, kStallFrom) << "too late to stall: the machine is busy";
  const auto broken = [](const ReceivedFrame& frame) { return frame.drivers->objects.back().revision > 0; };
  ASSERT_TRUE(sink_.wait([&](const SinkLog::State& state) { return broken(state.frames.back()); }));
  ASSERT_TRUE(sink_.wait_frames(20));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.added.empty() && state.removed.empty());
  int64_t gap_ns = 0;
  for (size_t i = 1; i < state.frames.size(); ++i) gap_ns = std::max(gap_ns, state.frames[i].received_ns - state.frames[i - 1].received_ns);
  EXPECT_TRUE(state.lost.empty() || gap_ns > 900'000'000);
  const int64_t stalled_ns = seen->stalled_ns, broken_ns = seen->broken_ns;
  EXPECT_GT(broken_ns, stalled_ns);
  const auto first = std::find_if(state.frames.begin(), state.frames.end(), broken);
  EXPECT_GE(first->received_ns, broken_ns + kStall_ns);  // nothing of it got through
  EXPECT_TRUE(std::all_of(first, state.frames.end(), broken));
  const uint32_t revision = first->drivers->objects.back().revision;
  const auto is_it = [&](const StreamedObject& object) { return object.rest.revision == revision; };
  ASSERT_EQ(std::count_if(state.changed.begin(), state.changed.end(), is_it), 1);
  const auto told = std::find_if(state.changed.begin(), state.changed.end(), is_it) - state.changed.begin();
  EXPECT_LE(state.changed_at[static_cast<size_t>(told)], static_cast<size_t>(first - state.frames.begin()));
  std::printf("broke %.1f ms into a stall that went on for %.0f; its first frame came %.1f ms after it\n", milliseconds_from_ns(broken_ns - stalled_ns),
              milliseconds_from_ns(kStall_ns), milliseconds_from_ns(first->received_ns - broken_ns - kStall_ns));
}

TEST_F(Faults, JitterOf40MsNeitherBreaksNorReorders) {
  start(box_scene());
  proxy_->set_link({.delay_ms = 1, .jitter_ms = 40});
  const size_t begin = sink_.state().frames.size();
  ASSERT_TRUE(sink_.wait_frames(60));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.lost.empty());
  for (size_t i = 1; i < state.frames.size(); ++i) EXPECT_GT(state.frames[i].tick, state.frames[i - 1].tick);
  // There was jitter: nine tenths of what is even from 0 to 40 ms are 36 ms wide, less what keeping their order takes from the early end.
  const double spread = spread_ms(std::span(state.frames).subspan(begin));
  std::printf("jitter of 40 ms: ages of nine tenths of the frames differ by %.1f ms\n", spread);
  EXPECT_GE(spread, 20.0);
}

// Both ends have one clock here, so the offset is 0. Over the wire: 20 ms of jitter each way.
TEST_F(Faults, TheClockIsKnownWithinAMillisecondUnder20MsOfJitter) {
  start(box_scene());
  proxy_->set_link({.delay_ms = 1, .jitter_ms = 20});
  sleep_until_ns(now_ns() + 3'000'000'000);
  const SinkLog::State state = sink_.state();
  EXPECT_GE(spread_ms(std::span(state.frames).last(state.frames.size() / 2)), 10.0);  // as above, of 20
  std::vector<double> errors_ms;
  for (const ReceivedFrame& frame : state.frames) {
    if (frame.received_ns < state.frames.back().received_ns - 2'000'000'000) continue;
    ASSERT_TRUE(frame.clock);
    errors_ms.push_back(std::abs(milliseconds_from_ns(frame.clock->offset_ns)));
    EXPECT_LE(std::abs(frame.clock->offset_ns), frame.clock->uncertainty_ns);
    // The moments of its way, in their order.
    EXPECT_LE(frame.stepped_ns, frame.encode_begun_ns);
    EXPECT_LE(frame.encode_begun_ns, frame.sent_ns);
    EXPECT_LE(frame.sent_ns, frame.received_ns);
    EXPECT_LE(frame.received_ns, frame.decoded_ns);
  }
  ASSERT_GT(errors_ms.size(), 20u);
  std::printf("clock off by p50 %.2f ms, p99 %.2f ms\n", percentile(errors_ms, 0.5), percentile(errors_ms, 0.99));
  EXPECT_LE(percentile(errors_ms, 0.99), 1.0);
}

// A tick that takes long is told of when it is done. So frames are older by as long as it takes, and by nothing else: not by a tick,
// which one that waits for the next would be, and no more at the end than at first.
TEST_F(Faults, ATickThatTakes40MsSlowsTheStreamAndNothingElse) {
  constexpr double kTakes_ms = 40;
  const auto slow = std::make_shared<std::atomic<bool>>(false);  // the server outlives this body
  start(box_scene(), [slow](const Scene&) {
    if (*slow) sleep_until_ns(now_ns() + static_cast<int64_t>(1e6 * kTakes_ms));
  });
  ASSERT_TRUE(sink_.wait_frames(40));
  const size_t quick = sink_.state().frames.size();
  *slow = true;
  const uint64_t slow_from = served_->tick + 2;
  ASSERT_TRUE(sink_.wait_frames(60));
  const SinkLog::State state = sink_.state();
  EXPECT_TRUE(state.lost.empty());
  const std::span frames(state.frames);
  const auto begun = std::find_if(frames.begin(), frames.end(), [&](const ReceivedFrame& frame) { return frame.tick > slow_from; });
  const auto late = frames.subspan(static_cast<size_t>(begun - frames.begin()));
  ASSERT_GE(late.size(), 40u);
  // The better half: the other says what else the machine does.
  const auto age_ms = [](std::span<const ReceivedFrame> some) { return percentile(ages_ms(some), 0.25); };
  const double before = age_ms(frames.first(quick)), first = age_ms(late.first(late.size() / 2)),
               second = age_ms(late.subspan(late.size() / 2));
  const double ticks = static_cast<double>(late.back().tick - late.front().tick);
  const double spacing_ms = milliseconds_from_ns(late.back().stepped_ns - late.front().stepped_ns) / ticks;
  std::printf("ticks of %.0f ms: one each %.1f ms, %.0f %% of them sent, %.1f then %.1f ms old; %.1f without\n", kTakes_ms, spacing_ms,
              100 * static_cast<double>(late.size() - 1) / ticks, first, second, before);
  EXPECT_GE(spacing_ms, kTakes_ms);
  EXPECT_GE(static_cast<double>(late.size() - 1), 0.6 * ticks);
  EXPECT_GE(first, kTakes_ms);
  EXPECT_LT(first, before + 1.5 * kTakes_ms);
  EXPECT_LT(second, before + 1.5 * kTakes_ms);
}

// A round trip of 40 ms. Two frames under way at a time are 50 a second; the window opens to four.
TEST(LongWay, KeepsTheRate) {
  NoiseServer noise(100);
  FaultProxy proxy(noise.port());
  SinkLog sink;
  const auto client = join(proxy.port());
  ASSERT_TRUE(client);
  proxy.set_link({.delay_ms = 20});
  client->start(sink);
  ASSERT_TRUE(sink.wait_frames(200));  // the window opens
  const size_t before = sink.state().frames.size();
  const uint64_t made_before = noise.newest;
  sleep_until_ns(now_ns() + 4'000'000'000);
  const auto frames = static_cast<double>(sink.state().frames.size() - before), made = static_cast<double>(noise.newest - made_before);
  std::printf("40 ms there and back: %.1f frames a second of %.1f made, in a window of %zu; two would give 50\n", frames / 4, made / 4,
              noise.server->session_table().sessions_now().front()->window());
  EXPECT_GE(frames, 0.85 * made);
  EXPECT_EQ(noise.server->session_table().sessions_now().front()->window(), 4u);
  EXPECT_TRUE(client->stop());
}

// 16 kB at 90 Hz are 11.5 Mbit/s. In a pipe of 8 a frame takes 16 ms; one may be under way, and the newest waits for its turn.
// Bar: p99 at most 60 ms, flat. `stream_bench --links` has the figures of a minute; beside other work each of the five waits on a
// frame's way may be late.
TEST(NarrowPipe, FramesThatDoNotFitAreLeftOutNotQueued) {
  NoiseServer noise(2667);
  FaultProxy proxy(noise.port());
  SinkLog sink;
  const auto client = join(proxy.port());
  ASSERT_TRUE(client);
  proxy.set_link({.delay_ms = 1, .mbit_s = 8});
  client->start(sink);
  ASSERT_TRUE(sink.wait_frames(50));  // the key frame's wake, and the window's first look
  const size_t begin = sink.state().frames.size();
  Lateness lateness;
  ASSERT_TRUE(sink.wait_frames(700));
  const double late_ms = lateness.allowance_ms(5);
  EXPECT_TRUE(client->stop());
  const SinkLog::State state = sink.state();
  EXPECT_TRUE(state.lost.empty());
  EXPECT_GT(state.frames.back().bytes, 15'000u);
  EXPECT_GT(state.frames.back().tick - state.frames.front().tick, state.frames.size() + 200);  // the others were left out
  const std::span frames = std::span(state.frames).subspan(begin);
  const double first = percentile(ages_ms(frames.first(frames.size() / 2)), 0.99);
  const double second = percentile(ages_ms(frames.subspan(frames.size() / 2)), 0.99);
  std::printf("8 Mbit/s: staleness p50 %.1f, p99 %.1f then %.1f ms (bar 60); the machine may be late by %.1f ms\n",
              percentile(ages_ms(frames), 0.5), first, second, late_ms);
  EXPECT_LT(percentile(ages_ms(frames), 0.99), 60 + late_ms);
  // Flat: a queue would add a second. One that just misses a tick waits for the next.
  constexpr double kTick_ms = 1e3 / 90;
  EXPECT_LT(second, 1.25 * first + kTick_ms + late_ms);
}

// Counts only: what it was given is gone.
class CountingSink final : public StreamSink {
 public:
  void on_lost(const std::string&) override { ++lost; }
  void on_resumed(const ResumedSession&) override {}
  void on_frame(ReceivedFrame) override {
    ++frames;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !frozen_; });
  }
  void on_object_added(StreamedObject) override {}
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}
  void freeze(bool frozen) {
    std::lock_guard lock(mutex_);
    frozen_ = frozen;
    changed_.notify_all();
  }

  std::atomic<uint64_t> frames{0}, lost{0};

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool frozen_ = false;
};

size_t resident_bytes() {
  std::ifstream file("/proc/self/statm");
  size_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * static_cast<size_t>(::sysconf(_SC_PAGESIZE));
}

// One of four takes nothing any more. A server that queued for it would hold 135 frames of 54 kB: 7 MB. A fifth stands still
// altogether: it is dropped. The bar is 2.5 s, and each of the waits on the way may be late beside other work.
TEST(SlowClient, HoldsUpNobodyAndCostsNoMemory) {
  NoiseServer noise(9000);
  std::vector<std::unique_ptr<CountingSink>> sinks;
  std::vector<std::unique_ptr<SessionClient>> clients;
  for (int i = 0; i < 4; ++i) {
    clients.push_back(join(noise.port()));
    ASSERT_TRUE(clients.back());
    sinks.push_back(std::make_unique<CountingSink>());
    clients.back()->start(*sinks.back());
  }
  const auto share_of = [&](int64_t duration_ns) {
    const uint64_t tick = noise.newest, before = sinks[0]->frames;
    sleep_until_ns(now_ns() + duration_ns);
    return static_cast<double>(sinks[0]->frames - before) / static_cast<double>(noise.newest - tick);
  };
  (void)share_of(300'000'000);
  const double together = share_of(700'000'000);
  sinks[3]->freeze(true);
  (void)share_of(200'000'000);
  const uint64_t frozen_at = sinks[3]->frames;
  const size_t before = resident_bytes();
  const double beside = share_of(1'500'000'000);
  const double grown_mb = 1e-6 * (static_cast<double>(resident_bytes()) - static_cast<double>(before));
  std::printf("frames got of those made: %.2f, beside a frozen client %.2f; memory %+.1f MB\n", together, beside, grown_mb);
  EXPECT_GT(beside, 0.8 * together);
  EXPECT_LT(grown_mb, 5.0);
  EXPECT_LE(sinks[3]->frames, frozen_at);
  // Its threads live and say so: it stays, and takes part again.
  sinks[3]->freeze(false);
  for (int i = 0; sinks[3]->frames < frozen_at + 5 && i < 6000; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_GE(sinks[3]->frames, frozen_at + 5);

  RawClient still(noise.port());
  ASSERT_TRUE(still.join().ok());
  still.open();
  v1::ServerMessage first;
  ASSERT_TRUE(still.read_any(first));
  ASSERT_EQ(noise.server->streaming_count(), 5u);
  Lateness lateness;
  const int64_t still_ns = now_ns();
  const uint64_t tick = noise.newest;
  std::array<uint64_t, 4> got{};
  for (size_t i = 0; i < 4; ++i) got[i] = sinks[i]->frames;
  while (noise.server->streaming_count() > 4 && now_ns() - still_ns < std::chrono::nanoseconds(kPatience).count())
    sleep_until_ns(now_ns() + 5'000'000);
  const double dropped_s = seconds_from_ns(now_ns() - still_ns), late_ms = lateness.allowance_ms(5);
  const auto made = static_cast<double>(noise.newest - tick);
  double least = 1;
  for (size_t i = 0; i < 4; ++i) least = std::min(least, static_cast<double>(sinks[i]->frames - got[i]) / made);
  std::printf("one that stands still is dropped after %.2f s (bar 2.5); the others got %.2f of the frames or more; the machine may be late by %.1f ms\n",
              dropped_s, least, late_ms);
  EXPECT_LE(dropped_s, 2.5 + 1e-3 * late_ms);
  EXPECT_GT(made, 90);
  EXPECT_GT(least, 0.8 * together);
  EXPECT_FALSE(still.finish_reading().ok());
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(sinks[i]->lost, 0u);
  for (auto& client : clients) EXPECT_TRUE(client->stop());
}

// Behind the floor a room of noise, which does not compress: some 700 kB.
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

TEST_F(Faults, AnAssetThatBreaksOffAt60PercentIsTakenUpThere) {
  const ScratchFolder folder;
  start(scene_with_a_room(folder));
  const StreamedObject& room = client_->scene().objects.at(0);
  const AssetCache cache(folder / "cache");
  size_t pieces = 0;
  std::vector<uint64_t> begun_at;
  std::vector<size_t> kernels;  // that could be drawn
  // So slow that a busy machine's client reads what has come: a reset takes with it what it has not.
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
  EXPECT_EQ(begun_at, (std::vector<uint64_t>{0}));  // the client takes it up by itself
  EXPECT_GT(pieces, 1u);
  // It could be drawn long before it was whole, coarse at first.
  ASSERT_GE(kernels.size(), 3u);
  EXPECT_LT(kernels.front(), 8000u);
  EXPECT_EQ(kernels.back(), 8000u);
  EXPECT_LT(room.asset_bytes, obtained->bytes.size());
  // All of it once, and what of a piece was on its way: the pipe holds 128 kB, a piece 64 kB. (And frames, some kB.)
  const uint64_t brought = proxy_->bytes_from_server() - before;
  EXPECT_LT(brought, room.asset_bytes + (256u << 10)) << room.asset_bytes;
  EXPECT_TRUE(sink_.state().lost.empty());  // the stream has a connection of its own
}

TEST_F(Faults, AnAssetThatIsAnotherAfterTheRestartIsTold) {
  start(box_scene());
  const JoinedScene& joined = client_->scene();
  proxy_->set_server(1);
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
  // The floor is drawn as large as the scene; the cube is what it was.
  for (const StreamedObject& object : state.added) EXPECT_TRUE(object.name == "box" || object.environment) << object.name;
}

// Connections that come, say nothing or nonsense, and go; sessions that are begun and left, more of them than there is room for. A
// thousand a second, client and server together on this machine: so fast go twenty of them, the quickest of fifty times; the others say
// what else the machine does.
TEST_F(Faults, AThousandConnectionsASecondDoNotDisturbWhoIsThere) {
  start(box_scene());
  // Of the ticks that are made meanwhile; with nobody else about first.
  const auto share_of = [this](const std::function<void()>& meanwhile) {
    const uint64_t tick = served_->tick;
    const size_t before = sink_.state().frames.size();
    meanwhile();
    return static_cast<double>(sink_.state().frames.size() - before) / static_cast<double>(served_->tick - tick);
  };
  const double alone = share_of([] { sleep_until_ns(now_ns() + 500'000'000); });
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(served_->port()));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  constexpr int kConnections = 1000, kCounted = 20;
  constexpr double kLeastRate = 1000;  // a second
  const int64_t begun_ns = now_ns();
  double rate = 0;
  const auto storm = [&] {
    int64_t counted_from_ns = now_ns();
    for (int i = 0; i < kConnections; ++i) {
      if (i > 0 && i % kCounted == 0) {
        rate = std::max(rate, kCounted / seconds_from_ns(now_ns() - counted_from_ns));
        counted_from_ns = now_ns();
      }
      const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
      ASSERT_EQ(::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
      if (i % 2 == 0) (void)!::send(socket, "GET / HTTP/1.1\r\n\r\n", 18, MSG_NOSIGNAL);
      ::close(socket);
      if (i % 10 != 0) continue;
      RawClient passer_by(served_->port());
      // Who was here before makes room as soon as the server has seen it go.
      for (int tries = 0; !passer_by.join().ok(); ++tries, std::this_thread::sleep_for(std::chrono::milliseconds(5))) ASSERT_LT(tries, 2000);
      if (i % 50 == 0) continue;  // joins, and never streams
      passer_by.open();
      v1::ServerMessage heard;
      ASSERT_TRUE(passer_by.read_any(heard));  // it has its stream; one that joins alone keeps its place for two minutes
      passer_by.cancel();
      EXPECT_FALSE(passer_by.finish_reading().ok());
    }
  };
  const double beside = share_of(storm);
  ASSERT_FALSE(HasFatalFailure());
  std::printf("%d connections in %.2f s, %.0f a second at best (bar %.0f); frames got of those made: %.2f, %.2f before\n", kConnections,
              seconds_from_ns(now_ns() - begun_ns), rate, kLeastRate, beside, alone);
  EXPECT_GE(rate, kLeastRate) << "a second";
  EXPECT_GT(beside, 0.6 * alone);
  ASSERT_TRUE(sink_.wait_frames(10));
  EXPECT_TRUE(sink_.state().lost.empty());
  EXPECT_GT(served_->server->sessions().sessions, kUsualSessions);
  SinkLog late;
  const auto other = join(served_->port());
  ASSERT_TRUE(other);
  other->start(late);
  EXPECT_TRUE(late.wait_frames(5));
  EXPECT_TRUE(other->stop());
}

}  // namespace
}  // namespace livegs
