// SPDX-License-Identifier: Apache-2.0
// Memory that is short for a moment: each allocation of a tick's way to the clients fails once, one after the other. The frame may
// be left out; what happened in it is told, once, and everything goes on.
#include <gtest/gtest.h>

#include <algorithm>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

#include "common/gaussian/synthetic_asset.h"
#include "core/clock.h"
#include "core/log.h"
#include "patience.h"
#include "scenes/box_scene.h"
#include "server/session/simulation/failing_memory.h"
#include "server/session/simulation/tick_log.h"
#include "session/assets/describe_object.h"
#include "session/publish/frame_publisher.h"
#include "session/frames/shared_frame_payload.h"
#include "session/live/run_controller.h"
#include "wire/kernel_codec.h"

namespace livegs {
namespace {

class NoInputs final : public InputSink {
 public:
  void hear(SessionNumber, std::span<const InputSample>) override {}
  void forget(SessionNumber) override {}
};

// A client that reads what there is as soon as it is woken, and joins again when its stream was ended.
class Client final : public SessionWriter, public std::enable_shared_from_this<Client> {
 public:
  explicit Client(SessionTable& table) : table_(table) {}

  void join(v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS) {
    JoinTerms terms;
    terms.encoding = encoding;
    const auto joined = table_.join(session_ ? session_->id : "", {}, terms);
    ASSERT_TRUE(joined) << joined.error().message;
    session_ = joined->session;
    std::lock_guard lock(mutex_);
    cut_off_ = false;
    for (const auto& object : joined->objects) know(*object);
    const auto stream = session_->attach(weak_from_this());
    ASSERT_TRUE(stream);
    stream_ = stream->stream;
  }
  void wake() override {
    const Unfailing here;
    std::lock_guard lock(mutex_);
    session_->heard_ns = now_ns();
    for (auto outgoing = session_->take(stream_, now_ns()); outgoing; outgoing = session_->take(stream_, now_ns())) {
      for (const v1::SessionEvent& event : outgoing->events) {
        ++events_;
        know(event.object_changed());
      }
      if (!outgoing->tick) continue;
      tick_ = outgoing->tick;
      (void)session_->acknowledge(stream_, tick_->tick(), now_ns());
    }
    changed_.notify_all();
  }
  void beat(int64_t) override {}
  void close(const std::string&) override {}
  void end(const Error&) override {}
  void end_without_session() override {}
  void abort() override {
    std::lock_guard lock(mutex_);
    cut_off_ = true;
    changed_.notify_all();
  }

  bool cut_off() {
    std::lock_guard lock(mutex_);
    return cut_off_;
  }
  // Until there is a tick from this on, the stream is over, or an allocation has failed.
  std::shared_ptr<const PublishedTick> wait(uint64_t tick) {
    std::unique_lock lock(mutex_);
    const auto until = std::chrono::steady_clock::now() + kPatience;
    const auto there = [&] { return tick_ && tick_->tick() >= tick; };
    while (!there() && !cut_off_ && !allocation_has_failed() && std::chrono::steady_clock::now() < until)
      changed_.wait_for(lock, std::chrono::milliseconds(5));
    return there() ? tick_ : nullptr;
  }
  double mass_kg(uint32_t id) {
    std::lock_guard lock(mutex_);
    return masses_kg_[id];
  }
  size_t events() {
    std::lock_guard lock(mutex_);
    return events_;
  }

 private:
  void know(const v1::ObjectDescription& object) { masses_kg_[object.object_id()] = object.mass_kg(); }

  SessionTable& table_;
  std::shared_ptr<ClientSession> session_;
  std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  uint64_t stream_ = 0;
  bool cut_off_ = false;
  size_t events_ = 0;
  std::shared_ptr<const PublishedTick> tick_;
  std::map<uint32_t, double> masses_kg_;
};

class ShortOfMemory : public ::testing::Test {
 protected:
  ShortOfMemory() : scene_(box_scene()) {
    set_log_level(LogLevel::Error);
    std::vector<const SceneObject*> objects;
    std::vector<SessionTable::Object> described;
    for (const SceneObject& object : scene_.objects()) {
      objects.push_back(&object);
      described.push_back(std::make_shared<const v1::ObjectDescription>(describe_object(object, assets_)));
      if (object.name == "box") box_ = object;
    }
    publisher_.begin_with(objects);
    table_.open("boxes", 90, std::move(described), inputs_);
  }
  ~ShortOfMemory() override {
    (void)end_failing();
    set_log_level(LogLevel::Info);
  }
  uint64_t publish(std::vector<SceneObject> changed = {}) {
    SteppedTick stepped;
    stepped.drivers = scene_.world().drivers();
    stepped.drivers.tick = ++number_;
    for (ObjectDrivers& one : stepped.drivers.objects) {
      one.asleep = false;
      if (one.object_id == box_.id) one.revision = box_.rest.revision;
    }
    stepped.stepped_ns = now_ns();
    stepped.changed = std::move(changed);
    publisher_.publish(std::move(stepped));
    return number_;
  }

  // The first of the publisher's allocations from `happen` on fails, then the second, until none does any more. With `happen`, for
  // which `prepare` makes everything ready, the box is told of, whose mass is another each time.
  void fail_each(const std::function<void()>& prepare, const std::function<uint64_t()>& happen) {
    client_->join();
    int failures = 0, cuts = 0, passed = 0;
    for (int number = 1; passed < 3 && number < 2000; ++number) {
      ASSERT_TRUE(client_->wait(publish()));
      const size_t before = client_->events();
      box_.mass_kg = number;
      prepare();
      EXPECT_EQ(client_->events(), before);
      fail_allocation("publisher", number);
      client_->wait(happen());
      // The thread may have failed after it told everybody, or be about to.
      for (int i = 0; i < 2; ++i) {
        if (client_->cut_off()) {
          ++cuts;
          client_->join();
        }
        client_->wait(publish());
        if (i == 0) (end_failing() ? ++failures : ++passed);
      }
      if (client_->cut_off()) {
        ++cuts;
        client_->join();
      }
      ASSERT_TRUE(client_->wait(publish())) << "after allocation " << number;
      EXPECT_EQ(client_->mass_kg(box_.id), number) << "after allocation " << number;
      EXPECT_LE(client_->events(), before + 1) << "after allocation " << number;
    }
    std::printf("%d allocations failed, one at a time; %d of them ended the stream\n", failures, cuts);
    EXPECT_EQ(passed, 3);
    EXPECT_GT(failures, 20);
    EXPECT_LT(cuts, failures);
  }

  Scene scene_;
  SceneObject box_;
  uint64_t number_ = 0;
  NoInputs inputs_;
  SessionTable table_;
  AssetStore assets_;
  const std::shared_ptr<Client> client_ = std::make_shared<Client>(table_);
  FramePublisher publisher_{table_, assets_};
};

TEST_F(ShortOfMemory, WhatHappensIsToldOnceAndTicksGoOn) {
  fail_each([] {}, [&] { return publish({box_}); });
}

// What waited for its kernels to be encoded is told of with the first tick after that.
TEST_F(ShortOfMemory, WhatWasEncodedIsToldOnceAndTicksGoOn) {
  fail_each(
      [&] {
        box_.asset = std::make_shared<const GaussianAsset>(synthetic_asset(20, 0, static_cast<uint64_t>(box_.mass_kg)));
        client_->wait(publish({box_}));
        const auto until = std::chrono::steady_clock::now() + kPatience;
        while (!assets_.has(box_.asset) && std::chrono::steady_clock::now() < until) std::this_thread::yield();
      },
      [&] { return publish(); });
}

KernelFrame kernels_in(const PublishedTick& tick) {
  const EncodedFrame frame = tick.by_itself(v1::JoinRequest::KERNELS);
  v1::ServerMessage message;
  EXPECT_TRUE(message.ParseFromArray(frame.tail->slice.begin(), static_cast<int>(frame.tail->slice.size())));
  auto kernels = decode_kernels(std::as_bytes(std::span(message.frame())));
  EXPECT_TRUE(kernels) << kernels.error().message;
  return std::move(*kernels);
}

TEST_F(ShortOfMemory, AFrameOfKernelsIsLeftOutAndTheNextIsWhole) {
  client_->join(v1::JoinRequest::KERNELS);
  const auto whole = client_->wait(publish());
  ASSERT_TRUE(whole);
  const size_t objects = kernels_in(*whole).objects.size();
  ASSERT_GE(objects, 3u);  // the floor's too
  int failures = 0, passed = 0;
  for (uint32_t number = 1; passed < 3 && number < 255; ++number) {
    box_.rest.revision = number;  // so that it is told of anew, and its kernels are tied anew
    fail_allocation("kernels", number);
    client_->wait(publish({box_}));
    client_->wait(publish());
    (end_failing() ? ++failures : ++passed);
    std::shared_ptr<const PublishedTick> next;
    // What could not be taken is taken with the next, which may be of a tick that has gone by.
    for (int tries = 0; tries < 3; ++tries) ASSERT_TRUE(next = client_->wait(publish())) << "after allocation " << number;
    const KernelFrame kernels = kernels_in(*next);
    ASSERT_EQ(kernels.objects.size(), objects) << "after allocation " << number;
    const auto box = std::find_if(kernels.objects.begin(), kernels.objects.end(), [&](const auto& one) { return one.object_id == box_.id; });
    ASSERT_NE(box, kernels.objects.end());
    EXPECT_EQ(box->revision, number);
    EXPECT_EQ(box->kernels.positions_m.size(), box_.asset->size());
  }
  std::printf("%d allocations failed, one at a time\n", failures);
  EXPECT_EQ(passed, 3);
  EXPECT_GT(failures, 20);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ShortOfThreads, AResetForWhichThereIsNoThreadSaysSoAndTheNextOneWorks) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  LiveRun run(loop, [](uint32_t first_id) -> Result<Scene> { return box_scene(90, 0.2, first_id); });
  loop.start();
  v1::ControlRunRequest reset;
  reset.set_reset(true);
  fail_threads(true);
  const auto refused = run.control(reset);
  fail_threads(false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::Unavailable);
  EXPECT_EQ(refused.error().message.find("reset: "), 0u) << refused.error().message;
  EXPECT_FALSE(loop.run_status().loading);
  EXPECT_TRUE(log.wait([](const auto& ticks) { return !ticks.empty() && !ticks.back().run.message.empty(); }));
  ASSERT_TRUE(run.control(reset));
  EXPECT_TRUE(log.wait([](const auto& ticks) { return ticks.back().run.resets == 1; }));
  loop.stop();
}

TEST_F(ShortOfMemory, WhatThereIsNoThreadToEncodeIsEncodedWhenThereIsOne) {
  client_->join();
  box_.asset = std::make_shared<const GaussianAsset>(synthetic_asset(50, 0, 1));
  box_.mass_kg = 7;
  fail_threads(true);
  ASSERT_TRUE(client_->wait(publish({box_})));
  ASSERT_TRUE(client_->wait(publish()));
  fail_threads(false);
  EXPECT_NE(client_->mass_kg(box_.id), 7);
  const auto until = std::chrono::steady_clock::now() + kPatience;
  while (client_->mass_kg(box_.id) != 7 && std::chrono::steady_clock::now() < until) ASSERT_TRUE(client_->wait(publish()));
  EXPECT_EQ(client_->mass_kg(box_.id), 7);
}
#endif

}  // namespace
}  // namespace livegs
