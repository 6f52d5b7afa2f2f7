// SPDX-License-Identifier: Apache-2.0
// Memory that is short within a simulation's tick: each of its allocations fails, one after the other, once or from then on.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <set>
#include <thread>

#include "core/clock.h"
#include "core/log.h"
#include "scenes/box_scene.h"
#include "server/session/simulation/failing_memory.h"
#include "server/session/simulation/tick_log.h"
#include "session/live/run_controller.h"
#include "session/simulation/memory_reserve.h"

namespace livegs {
namespace {

using Ticks = std::vector<SteppedTick>;

constexpr double kRate_hz = 400;
constexpr int kAllocationsOfBreak = 400;  // of the tick in which it is, and more
constexpr uint64_t kBreaksAfter = 20;  // ticks

bool same_bits(const DriverFrame& a, const DriverFrame& b) {
  return std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(), [](const ObjectDrivers& one, const ObjectDrivers& other) {
    return one.object_id == other.object_id && one.revision == other.revision && one.asleep == other.asleep &&
           one.positions_m == other.positions_m &&
           std::equal(one.poses.begin(), one.poses.end(), other.poses.begin(), other.poses.end(), [](const Pose& p, const Pose& q) {
             return p.position_m == q.position_m && p.orientation.coeffs() == q.orientation.coeffs();
           });
  });
}

class ShortStep : public ::testing::Test {
 protected:
  ShortStep() { set_log_level(LogLevel::Error); }
  ~ShortStep() override {
    (void)end_failing();
    loop_->stop();
    set_log_level(LogLevel::Info);
  }
  void start(const std::function<Scene(uint32_t first_id)>& make, std::function<void(const Scene&)> observe = {}) {
    loop_ = std::make_unique<SimulationLoop>(make(1), log_, std::move(observe));
    run_ = std::make_unique<LiveRun>(*loop_, [make](uint32_t first_id) -> Result<Scene> { return make(first_id); });
    loop_->start();
  }
  SteppedTick newest() {
    SteppedTick tick;
    EXPECT_TRUE(log_.wait([&](const Ticks& ticks) {
      if (ticks.empty()) return false;
      tick = ticks.back();
      return true;
    }));
    return tick;
  }
  SteppedTick wait(const std::function<bool(const SteppedTick&)>& until) {
    SteppedTick tick;
    EXPECT_TRUE(log_.wait([&](const Ticks& ticks) {
      if (ticks.empty() || !until(ticks.back())) return false;
      tick = ticks.back();
      return true;
    }));
    return tick;
  }
  void wait_ticks(size_t more) {
    const uint64_t tick = newest().drivers.tick;
    (void)wait([&](const SteppedTick& one) { return one.drivers.tick >= tick + more; });
  }
  static void wait_for_failure() {
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (!allocation_has_failed() && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    ASSERT_TRUE(allocation_has_failed());
  }
  static v1::ControlRunRequest resume() {
    v1::ControlRunRequest request;
    request.set_pause(false);
    return request;
  }
  static v1::ControlRunRequest reset() {
    v1::ControlRunRequest request;
    request.set_reset(true);
    return request;
  }

  TickLog log_;
  std::unique_ptr<SimulationLoop> loop_;
  std::unique_ptr<LiveRun> run_;
};

// A scene in which nothing fails.
class Undisturbed {
 public:
  explicit Undisturbed(Scene scene) : scene_(std::move(scene)), steps_{scene_.world().drivers()} {}
  // What was stepped is the same to the bit, each step once and none left out.
  void expect(const Ticks& ticks) {
    size_t step = 0;
    for (const SteppedTick& tick : ticks) {
      if (tick.drivers.simulated_ns != steps_[step].simulated_ns && ++step == steps_.size()) {
        scene_.step();
        steps_.push_back(scene_.world().drivers());
      }
      ASSERT_EQ(tick.drivers.simulated_ns, steps_[step].simulated_ns);
      ASSERT_TRUE(same_bits(tick.drivers, steps_[step])) << "tick " << tick.drivers.tick;
    }
  }

 private:
  Scene scene_;
  std::vector<DriverFrame> steps_;
};

Scene boxes(uint32_t first_id = 1) { return box_scene(kRate_hz, 0.2, first_id); }
Scene breaking(uint32_t first_id = 1) { return breaking_scene(kRate_hz, first_id, kBreaksAfter / kRate_hz); }

TEST_F(ShortStep, ATickThatFindsNoMemoryIsFinishedAndTheSceneGoesOnAsIfNothingHadBeen) {
  constexpr int kAllocations = 150;  // of a few ticks
  start(boxes);
  wait_ticks(2);
  for (int number = 1; number <= kAllocations; ++number) {
    fail_allocation("simulation", number);
    wait_for_failure();
    (void)end_failing();
    const SteppedTick told = wait([](const SteppedTick& tick) { return tick.run.paused; });
    EXPECT_NE(told.run.message.find("memory is short"), std::string::npos) << told.run.message;
    wait_ticks(2);
    EXPECT_EQ(newest().drivers.simulated_ns, told.drivers.simulated_ns) << "allocation " << number;
    ASSERT_TRUE(run_->control(resume()));
    const SteppedTick going = wait([&](const SteppedTick& tick) { return tick.drivers.simulated_ns > told.drivers.simulated_ns; });
    EXPECT_EQ(going.run.message, "");
  }
  loop_->stop();
  const Ticks ticks = log_.ticks();
  for (size_t i = 1; i < ticks.size(); ++i) ASSERT_EQ(ticks[i].drivers.tick, ticks[i - 1].drivers.tick + 1);
  Undisturbed(boxes()).expect(ticks);
}

// The same in the tick in which something breaks, which is told once.
TEST_F(ShortStep, ABreakThatFindsNoMemoryIsTheSameBreak) {
  Undisturbed undisturbed(breaking());
  for (int number = 1; number < kAllocationsOfBreak; number += 37) {
    log_.clear();
    const auto armed = std::make_shared<bool>(false);
    start(breaking, [=](const Scene& scene) {
      if (scene.world().tick() == kBreaksAfter && !std::exchange(*armed, true)) fail_allocation("simulation", number);
    });
    wait_for_failure();
    (void)end_failing();
    (void)wait([](const SteppedTick& tick) { return tick.run.paused; });
    ASSERT_TRUE(run_->control(resume()));
    (void)wait([](const SteppedTick& tick) { return tick.drivers.simulated_ns > 1.25e9 * kBreaksAfter / kRate_hz; });
    loop_->stop();
    const Ticks ticks = log_.ticks();
    EXPECT_EQ(std::count_if(ticks.begin(), ticks.end(), [](const SteppedTick& tick) { return !tick.changed.empty(); }), 1) << "allocation " << number;
    undisturbed.expect(ticks);
  }
}

// No reserve is enough: clients keep what they were told last, are told so, and a reset brings the scene again.
class GivenUp : public ShortStep {
 protected:
  void expect_reset_after_failure(int number) {
    const uint64_t waits_before = loop_->summary().waits;
    wait_for_failure();
    const auto given_up = [&] { return loop_->run_status().message.find("reset") != std::string::npos; };
    const auto waits = [&] { return loop_->summary().waits > waits_before + 1; };
    const auto until = std::chrono::steady_clock::now() + kPatience;
    while (!given_up() && !waits() && std::chrono::steady_clock::now() < until) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // and goes on failing for a tick or two
    (void)end_failing();
    if (!given_up()) {  // it was the telling of a tick that was done: it is told now
      (void)wait([](const SteppedTick& tick) { return tick.run.message.find("memory is short") != std::string::npos; });
      ASSERT_TRUE(run_->control(resume()));
      return;
    }
    const SteppedTick told = wait([](const SteppedTick& tick) { return tick.run.message.find("reset") != std::string::npos; });
    EXPECT_TRUE(told.run.paused);
    wait_ticks(2);
    const SteppedTick held = newest();
    EXPECT_TRUE(same_bits(held.drivers, told.drivers)) << "allocation " << number;
    EXPECT_EQ(held.drivers.simulated_ns, told.drivers.simulated_ns);
    // A tick of what is held that finds no memory in its turn, and is finished, does not make it anything less.
    fail_allocation("simulation", 1);
    wait_for_failure();
    (void)end_failing();
    wait_ticks(2);
    EXPECT_NE(newest().run.message.find("reset"), std::string::npos) << newest().run.message;
    const auto refused = run_->control(resume());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::Unavailable);
    const uint32_t resets = held.run.resets;
    ASSERT_TRUE(run_->control(reset()));
    const SteppedTick anew = wait([&](const SteppedTick& tick) { return tick.run.resets > resets; });
    EXPECT_FALSE(anew.run.paused) << "allocation " << number;
    EXPECT_EQ(anew.run.message, "");
    (void)wait([&](const SteppedTick& tick) { return tick.drivers.simulated_ns > anew.drivers.simulated_ns; });
  }
  // What came, went and is there agree in every tick; ticks and simulated time go on, and a tick that was given up is none.
  void expect_whole(std::set<uint32_t> known) {
    loop_->stop();
    const Ticks ticks = log_.ticks();
    for (size_t i = 0; i < ticks.size(); ++i) {
      const SteppedTick& tick = ticks[i];
      for (const uint32_t id : tick.removed) EXPECT_EQ(known.erase(id), 1u) << "tick " << tick.drivers.tick;
      for (const SceneObject& object : tick.added) EXPECT_TRUE(known.insert(object.id).second) << "tick " << tick.drivers.tick;
      std::set<uint32_t> there;
      for (const ObjectDrivers& one : tick.drivers.objects) there.insert(one.object_id);
      ASSERT_EQ(there, known) << "tick " << tick.drivers.tick;
      if (i == 0) continue;
      ASSERT_EQ(tick.drivers.tick, ticks[i - 1].drivers.tick + 1);
      ASSERT_GE(tick.drivers.simulated_ns, ticks[i - 1].drivers.simulated_ns);
      if (tick.run.message.find("reset") == std::string::npos) continue;
      ASSERT_TRUE(same_bits(tick.drivers, ticks[i - 1].drivers)) << "tick " << tick.drivers.tick;
    }
  }
};

std::set<uint32_t> ids_of(const Scene& scene) {
  std::set<uint32_t> ids;
  for (const SceneObject& object : scene.objects()) ids.insert(object.id);
  return ids;
}

TEST_F(GivenUp, WhereNoReserveIsEnoughClientsKeepWhatTheyHaveAndAResetHelps) {
  constexpr int kAllocations = 60;
  start(boxes);
  wait_ticks(2);
  for (int number = 1; number <= kAllocations && !HasFatalFailure(); number += 2) {
    fail_allocations_from("simulation", number);
    expect_reset_after_failure(number);
  }
  expect_whole(ids_of(boxes()));
}

TEST_F(GivenUp, ABreakThatIsGivenUpHasNotBeen) {
  const auto next = std::make_shared<std::atomic<int>>(1);
  start(breaking, [=](const Scene& scene) {
    if (scene.world().tick() == kBreaksAfter) fail_allocations_from("simulation", next->load());
  });
  for (; *next < kAllocationsOfBreak && !HasFatalFailure(); *next += 37) expect_reset_after_failure(*next);
  expect_whole(ids_of(breaking()));
}

TEST(MemoryReserve, IsLentPieceByPieceAndFilledAgain) {
  ASSERT_TRUE(MemoryReserve::fill());
  fail_allocations_from("this thread", 1);
  pthread_setname_np(pthread_self(), "this thread");
  const auto take = [] { ::operator delete(::operator new(4)); };  // which no compiler leaves out
  EXPECT_THROW(take(), std::bad_alloc) << "it is not lent";
  {
    const MemoryReserve::Lent lent;
    EXPECT_FALSE(lent.used());
    EXPECT_THROW(take(), std::bad_alloc);
    EXPECT_TRUE(lent.used());
  }
  (void)end_failing();
  ASSERT_TRUE(MemoryReserve::fill());
  const MemoryReserve::Lent lent;
  for (size_t i = 0; i < MemoryReserve::kPieces; ++i) {
    fail_allocation("this thread", 1);
    EXPECT_NO_THROW(take()) << i;
  }
  EXPECT_TRUE(lent.used());
  fail_allocation("this thread", 1);
  EXPECT_THROW(take(), std::bad_alloc) << "all of it is used";
  (void)end_failing();
  EXPECT_TRUE(MemoryReserve::fill());
}

}  // namespace
}  // namespace livegs
