// SPDX-License-Identifier: Apache-2.0
// Publisher and spectators in one process, including slow spectators.
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <thread>

#include "core/clock.h"
#include "patience.h"
#include "scenes/box_scene.h"
#include "server/session/support/no_inputs.h"
#include "session/publish/zmq_publisher.h"
#include "session/rpc/grpc_server.h"
#include "session/simulation/scene_run.h"
#include "stream/session/spectator.h"

namespace livegs {
namespace {

// Stores the received updates. `taking` is called for each frame and may block.
class Watched final : public StreamSink {
 public:
  void on_lost(const std::string&) override {}
  void on_resumed(const ResumedSession& resumed) override {
    std::lock_guard lock(mutex_);
    servers_ += resumed.same_server ? 0 : 1;
  }
  void on_frame(ReceivedFrame frame) override {
    taking(frame);
    std::lock_guard lock(mutex_);
    for (const ObjectDrivers& object : frame.drivers->objects) {
      const auto known = revisions_.find(object.object_id);
      fits_ = fits_ && known != revisions_.end() && known->second == object.revision;
    }
    ticks_.push_back(frame.tick);
    changed_.notify_all();
  }
  void on_object_added(StreamedObject object) override { know(object); }
  void on_object_changed(StreamedObject object) override { know(object); }
  void on_object_removed(uint32_t id) override {
    std::lock_guard lock(mutex_);
    revisions_.erase(id);
  }
  void on_draining(const std::string&) override {}

  void know(const StreamedObject& object) {
    std::lock_guard lock(mutex_);
    revisions_[object.id] = object.rest.revision;
  }
  std::vector<uint64_t> ticks() const {
    std::lock_guard lock(mutex_);
    return ticks_;
  }
  bool wait(const std::function<bool(const std::vector<uint64_t>& ticks)>& enough) const {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return enough(ticks_); });
  }
  // True if every frame contained only objects and revisions that had been described before.
  bool fits() const {
    std::lock_guard lock(mutex_);
    return fits_;
  }
  size_t objects() const {
    std::lock_guard lock(mutex_);
    return revisions_.size();
  }
  size_t servers() const {
    std::lock_guard lock(mutex_);
    return servers_;
  }
  std::function<void(const ReceivedFrame&)> taking = [](const ReceivedFrame&) {};

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::vector<uint64_t> ticks_;
  std::map<uint32_t, uint32_t> revisions_;
  size_t servers_ = 0;
  bool fits_ = true;
};

// A server that publishes and is stepped by the test.
class SpectatorsTest : public ::testing::Test {
 protected:
  void open(Scene scene, const std::string& address = "tcp://127.0.0.1:0",
            const std::string& listen = "127.0.0.1:0") {
    auto listening = GrpcServer::listen(listen);
    ASSERT_TRUE(listening) << listening.error().message;
    server = std::move(*listening);
    auto published = server->publish(address);
    ASSERT_TRUE(published) << published.error().message;
    where = *published;
    run.emplace(std::move(scene));
    server->open(run->scene(), inputs);
  }
  void step(const TickActions& actions = {}) {
    TickResult stepped = run->advance(actions);
    tick = stepped.drivers.tick;
    server->ticks().publish(std::move(stepped));
  }
  // A subscription takes effect once the publisher has received it, so this steps the server until then.
  std::unique_ptr<Spectator> subscribe(Watched& watched) {
    auto spectator = Spectator::subscribe("127.0.0.1:" + std::to_string(server->port()), where);
    EXPECT_TRUE(spectator) << spectator.error().message;
    if (!spectator) return nullptr;
    for (const StreamedObject& object : (*spectator)->scene().objects) watched.know(object);
    (*spectator)->start(watched);
    EXPECT_TRUE(step_until([&] { return !watched.ticks().empty(); }));
    return std::move(*spectator);
  }
  bool step_until(const std::function<bool()>& enough) {
    const int64_t give_up_ns = now_ns() + std::chrono::nanoseconds(kPatience).count();
    while (!enough() && now_ns() < give_up_ns) {
      step();
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return enough();
  }

  NoInputs inputs;
  std::unique_ptr<GrpcServer> server;
  std::string where;
  std::optional<SceneRun> run;
  std::atomic<uint64_t> tick{0};
};

// A spectator that stalls for 300 ticks continues with one of the last frames; the other spectator is not
// delayed. Without ZMQ_CONFLATE, hundreds of frames would be queued.
TEST_F(SpectatorsTest, StalledSpectatorDelaysNoOther) {
  open(box_scene());
  Watched quick, sleeper;
  std::mutex gate;
  sleeper.taking = [&](const ReceivedFrame&) { std::lock_guard open_gate(gate); };
  auto quick_one = subscribe(quick);
  auto sleeping_one = subscribe(sleeper);
  ASSERT_TRUE(quick_one && sleeping_one);
  size_t before = 0;
  {
    std::lock_guard shut(gate);
    for (int i = 0; i < 300; ++i) {
      step();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(quick.wait([&](const auto& ticks) { return !ticks.empty() && ticks.back() == tick; }));
    before = sleeper.ticks().size();
  }
  ASSERT_TRUE(sleeper.wait([&](const auto& ticks) { return !ticks.empty() && ticks.back() == tick; }));
  // Normally 2: the frame in progress and the newest. More if its socket thread is late as well.
  EXPECT_LE(sleeper.ticks().size() - before, 30u);
}

// A spectator that takes 40 ticks per frame receives frames of about that age, without accumulating delay.
TEST_F(SpectatorsTest, SlowSpectatorDoesNotFallFurtherBehind) {
  open(box_scene());
  constexpr uint64_t kTakes = 40;  // ticks
  Watched slow;
  std::mutex mutex;
  std::vector<uint64_t> ages;  // age of each frame on arrival, ticks
  slow.taking = [&](const ReceivedFrame& frame) {
    const uint64_t from = tick;
    for (int i = 0; tick < from + kTakes && i < 1000; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::lock_guard lock(mutex);
    ages.push_back(from - frame.tick);
  };
  auto spectator = subscribe(slow);
  ASSERT_TRUE(spectator);
  ASSERT_TRUE(step_until([&] { return slow.ticks().size() >= 12; }));
  std::lock_guard lock(mutex);
  // A frame queue would add 40 ticks per frame.
  for (size_t i = 4; i < ages.size(); ++i) EXPECT_LE(ages[i], 3 * kTakes) << i;
}

// Balls appear and disappear, and an object breaks. Frames contain only objects that have been described.
TEST_F(SpectatorsTest, DescriptionsPrecedeTheirFrames) {
  open(breaking_scene());
  Watched watched;
  auto spectator = subscribe(watched);
  ASSERT_TRUE(spectator);
  const size_t whole = watched.objects();
  for (int i = 0; i < 40; ++i) {
    if (i % 2 == 0) run->scene().shoot_ball({0, 1, 1}, {0, 0, -3});
    step();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const auto newest = [&] { return !watched.ticks().empty() && watched.ticks().back() >= tick - 1; };
  ASSERT_TRUE(step_until([&] { return watched.objects() == whole + Scene::kMaxBalls && newest(); }));
  ASSERT_TRUE(step_until([&] { return tick > 100 && newest(); }));  // the break is in tick 90
  EXPECT_TRUE(watched.fits());
  const Spectator::Totals totals = spectator->totals();
  EXPECT_GE(totals.described, 3u);
  EXPECT_GT(totals.frames, 10u);
}

// A restarted server on the same addresses is a new instance: its scene is requested again, and its ticks
// start from the beginning.
TEST_F(SpectatorsTest, FollowsARestartedServer) {
  open(box_scene());
  Watched watched;
  auto spectator = subscribe(watched);
  ASSERT_TRUE(spectator);
  const int port = server->port();
  server.reset();
  open(box_scene(), where, "127.0.0.1:" + std::to_string(port));
  const size_t before = watched.ticks().size();
  ASSERT_TRUE(step_until([&] { return watched.ticks().size() > before + 3; }));
  EXPECT_EQ(watched.servers(), 1u);
  EXPECT_TRUE(watched.fits());
}

TEST(Publishing, RefusesRemoteAndInvalidAddresses) {
  for (const std::string address :
       {"tcp://0.0.0.0:9782", "tcp://192.168.1.5:9782", "tcp://[::]:9782", "tcp://*:9782"}) {
    const auto bound = ZmqPublisher::bind(address);
    ASSERT_FALSE(bound) << address;
    EXPECT_EQ(bound.error().code, ErrorCode::InvalidArgument);
    EXPECT_NE(bound.error().message.find("is not local"), std::string::npos) << bound.error().message;
  }
  for (const std::string address :
       {"127.0.0.1:9782", "ipc:///tmp/x", "tcp://127.0.0.1", "tcp://127.0.0.1:99999", ""}) {
    const auto bound = ZmqPublisher::bind(address);
    ASSERT_FALSE(bound) << address;
    EXPECT_EQ(bound.error().code, ErrorCode::InvalidArgument);
  }
  auto first = ZmqPublisher::bind("tcp://localhost:0");
  ASSERT_TRUE(first) << first.error().message;
  const auto second = ZmqPublisher::bind((*first)->address());
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::Unavailable);
  EXPECT_FALSE((*first)->has_subscribers());
}

}  // namespace
}  // namespace livegs
