// SPDX-License-Identifier: Apache-2.0
#include "session/fleet/fleet_member.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "patience.h"
#include "scenes/box_scene.h"
#include "server/session/fleet/agones_sidecar.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {
namespace {

constexpr const char* kHealth = "POST /health";
constexpr const char* kReady = "POST /ready";
constexpr const char* kAllocate = "POST /allocate";
constexpr const char* kShutdown = "POST /shutdown";
constexpr const char* kRead = "GET /gameserver";
constexpr const char* kLabel = "PUT /metadata/label";
constexpr const char* kPeople = "PATCH /v1beta1/counters/people";

class Fleet : public ::testing::Test {
 protected:
  // A tick passes at every look, unless they are stuck.
  void open(double empty_s = kFleetEmpty_s, double next_address_s = kNextAddressWait_s) {
    member_ = std::make_unique<FleetMember>(
        FleetMember::Options{.port = sidecar_->port(), .empty_s = empty_s, .next_address_s = next_address_s});
    ASSERT_TRUE(wait_until([&] { return member_->name().has_value(); }));
    ASSERT_TRUE(*member_->name()) << member_->name()->error().message;
    member_->open("00d1ce00d1ce00d1", [&]() -> FleetMember::Facts { return {++ticks_, people_, 64, 4.25}; });
  }
  // A person who joined.
  void join_person() {
    ASSERT_TRUE(sidecar_->wait_for(kReady));
    people_ = 1;
    ASSERT_TRUE(sidecar_->wait_for(kAllocate));
  }
  std::atomic<uint64_t> ticks_ = 0;
  std::atomic<size_t> people_ = 0;
  std::unique_ptr<AgonesSidecar> sidecar_ = std::make_unique<AgonesSidecar>();
  std::unique_ptr<FleetMember> member_;
};

TEST_F(Fleet, IsReadyAfterItsLabelAndCounter) {
  open();
  EXPECT_EQ(**member_->name(), "room-x7k2p");
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  ASSERT_TRUE(sidecar_->wait_for(kHealth, 3));
  const auto calls = sidecar_->calls();
  EXPECT_EQ(sidecar_->first(kRead), 0u);
  EXPECT_LT(sidecar_->first(kLabel), sidecar_->first(kReady));
  EXPECT_LT(sidecar_->first(kPeople), sidecar_->first(kReady));
  EXPECT_EQ(calls[sidecar_->first(kLabel)].body, R"({"key":"livegs-scene","value":"00d1ce00d1ce00d1"})");
  EXPECT_EQ(calls[sidecar_->first(kPeople)].body, R"({"capacity":"64","count":"0"})");
  EXPECT_TRUE(sidecar_->wait_for_body(kLabel, R"({"key":"livegs-tick-p99-ms","value":"4.25"})"));
  EXPECT_EQ(sidecar_->count(kReady), 1u);
  EXPECT_EQ(sidecar_->count(kAllocate), 0u);
}

TEST_F(Fleet, AllocatesOnceForTheFirstPersonAndCountsPeople) {
  open();
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  people_ = 1;
  ASSERT_TRUE(sidecar_->wait_for(kAllocate));
  ASSERT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"1")"));
  people_ = 2;
  ASSERT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"2")"));
  people_ = 0;
  ASSERT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"0")"));
  people_ = 3;
  ASSERT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"3")"));
  EXPECT_EQ(sidecar_->count(kAllocate), 1u);
}

TEST_F(Fleet, LeavesAnAllocationOfTheFleetAsItIs) {
  open();
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  sidecar_->set_state("Allocated");
  people_ = 1;
  ASSERT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"1")"));
  EXPECT_EQ(sidecar_->count(kAllocate), 0u);
}

TEST_F(Fleet, IsEmptyAfterTheLastPersonAndThenShutsDown) {
  constexpr double kEmpty_s = 1;
  open(kEmpty_s);
  people_ = 1;
  ASSERT_TRUE(sidecar_->wait_for(kAllocate));
  EXPECT_FALSE(member_->empty());
  const int64_t left_ns = now_ns();
  people_ = 0;
  ASSERT_TRUE(wait_until([&] { return member_->empty(); }));
  EXPECT_GE(seconds_from_ns(now_ns() - left_ns), kEmpty_s);
  EXPECT_EQ(sidecar_->count(kShutdown), 0u);
  member_->leave();
  const auto calls = sidecar_->calls();
  EXPECT_EQ(calls.back().what, kShutdown);
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // longer than the pause of Health
  EXPECT_EQ(sidecar_->calls().size(), calls.size());
}

TEST_F(Fleet, IsEmptyIfNobodyComesToItsAllocation) {
  open(1);
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  sidecar_->set_state("Allocated");
  EXPECT_TRUE(wait_until([&] { return member_->empty(); }));
}

TEST_F(Fleet, StaysWithoutPeopleUntilItIsAllocated) {
  open(0.5);
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  ASSERT_TRUE(sidecar_->wait_for(kHealth, 4));
  EXPECT_FALSE(member_->empty());
}

// A simulation that hangs in a tick. The thread that reports still runs: it reads the GameServer.
TEST_F(Fleet, EndsHealthWithinTwoSecondsOfAStuckTick) {
  class Count final : public TickSink {
   public:
    void publish(TickResult&&) override { ++ticks; }
    std::atomic<uint64_t> ticks = 0;
  } sink;
  std::atomic<bool> stuck = false, hangs = false;
  SimulationLoop loop(box_scene(), sink, [&](const Scene&) {
    hangs = stuck.load();
    stuck.wait(true);
  });
  member_ = std::make_unique<FleetMember>(FleetMember::Options{.port = sidecar_->port()});
  ASSERT_TRUE(wait_until([&] { return member_->name().has_value(); }));
  loop.start();
  member_->open("00d1ce00d1ce00d1", [&]() -> FleetMember::Facts { return {sink.ticks, 0, 64, 1}; });
  ASSERT_TRUE(sidecar_->wait_for(kHealth, 2));
  stuck = true;
  ASSERT_TRUE(wait_until([&] { return hangs.load(); }));
  const int64_t stuck_ns = now_ns();
  const size_t reads = sidecar_->count(kRead);
  ASSERT_TRUE(sidecar_->wait_for(kRead, reads + 2));
  EXPECT_LT(seconds_from_ns(sidecar_->last_ns(kHealth) - stuck_ns), 2);
  const size_t reported = sidecar_->count(kHealth);
  stuck = false;
  stuck.notify_all();
  EXPECT_TRUE(sidecar_->wait_for(kHealth, reported + 1));
  loop.stop();
  member_.reset();
}

TEST_F(Fleet, WaitsForASidecarThatIsTwentySecondsLate) {
  const int port = sidecar_->port();
  sidecar_.reset();
  member_ = std::make_unique<FleetMember>(FleetMember::Options{.port = port});
  std::this_thread::sleep_for(std::chrono::seconds(20));
  EXPECT_FALSE(member_->name().has_value());
  sidecar_ = std::make_unique<AgonesSidecar>(port);
  ASSERT_TRUE(wait_until([&] { return member_->name().has_value(); }));
  ASSERT_TRUE(*member_->name());
  member_->open("00d1ce00d1ce00d1", [&]() -> FleetMember::Facts { return {++ticks_, 0, 64, 1}; });
  EXPECT_TRUE(sidecar_->wait_for(kReady));
}

TEST_F(Fleet, NamesTheRemedyWithoutASidecar) {
  const int port = sidecar_->port();
  sidecar_.reset();
  FleetMember member({.port = port, .sidecar_timeout_s = 0.5});
  ASSERT_TRUE(wait_until([&] { return member.name().has_value(); }));
  ASSERT_FALSE(*member.name());
  EXPECT_EQ(member.name()->error().code, ErrorCode::Unavailable);
  EXPECT_NE(member.name()->error().message.find("without --fleet"), std::string::npos);
  EXPECT_EQ(member.leave().address, "");
}

TEST_F(Fleet, RepeatsItsCallsWhenTheSidecarIsGoneAndReturns) {
  open();
  ASSERT_TRUE(sidecar_->wait_for_body(kLabel, kTickLabel));  // follows the reply to Ready
  const int port = sidecar_->port();
  sidecar_.reset();
  people_ = 1;
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_FALSE(member_->empty());
  sidecar_ = std::make_unique<AgonesSidecar>(port);
  EXPECT_TRUE(sidecar_->wait_for(kAllocate));
  EXPECT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"1")"));
  EXPECT_TRUE(sidecar_->wait_for_body(kLabel, kSceneLabel));
  EXPECT_TRUE(sidecar_->wait_for(kHealth, 2));
  EXPECT_EQ(sidecar_->count(kReady), 0u);  // the state of the GameServer is not the sidecar's
}

TEST_F(Fleet, RepeatsReadyUntilItIsAccepted) {
  sidecar_->refuse(kReady, 500);
  open();
  people_ = 1;
  ASSERT_TRUE(sidecar_->wait_for(kReady, 3));
  EXPECT_EQ(sidecar_->count(kAllocate), 0u);
  sidecar_->accept(kReady);
  EXPECT_TRUE(sidecar_->wait_for(kAllocate));
}

// A fault of the sidecar that passes, before Ready and later.
TEST_F(Fleet, RepeatsACounterAndALabelThatItsSidecarFailsToTake) {
  sidecar_->refuse(kLabel, 503);
  open();
  ASSERT_TRUE(sidecar_->wait_for(kLabel, 3));
  EXPECT_EQ(sidecar_->count(kReady), 0u);
  sidecar_->accept(kLabel);
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  ASSERT_TRUE(sidecar_->wait_for_accepted(kPeople, R"("count":"0")"));
  sidecar_->refuse(kPeople, 503);
  people_ = 2;
  ASSERT_TRUE(sidecar_->wait_for_body(kPeople, R"("count":"2")"));
  ASSERT_TRUE(sidecar_->wait_for(kPeople, sidecar_->count(kPeople) + 2));
  sidecar_->accept(kPeople);
  EXPECT_TRUE(sidecar_->wait_for_accepted(kPeople, R"("count":"2")"));
  people_ = 3;
  EXPECT_TRUE(sidecar_->wait_for_accepted(kPeople, R"("count":"3")"));
}

// With the status and the text of Agones.
TEST_F(Fleet, DoesWithoutACounterThatTheSpecLacks) {
  sidecar_->refuse(kPeople, 500, "counter not found: people");
  open();
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  people_ = 1;
  ASSERT_TRUE(sidecar_->wait_for(kAllocate));
  ASSERT_TRUE(sidecar_->wait_for(kHealth, 3));
  EXPECT_EQ(sidecar_->count(kPeople), 1u);
}

// A sidecar that accepts connections and sends nothing.
TEST_F(Fleet, ReportsHealthToASidecarWhoseOtherCallsHang) {
  sidecar_->refuse(kReady, 0);
  open();
  EXPECT_TRUE(sidecar_->wait_for(kHealth, 3));
  EXPECT_GE(sidecar_->count(kReady), 2u);
}

TEST_F(Fleet, ReadsTheNextAddressWhenItLeaves) {
  open();
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  sidecar_->set_annotations(
      R"("livegs.io/next-address": "10.0.0.8:7777", "livegs.io/next-server": "room-b", "other": "x")");
  const Successor next = member_->leave();
  EXPECT_EQ(next.address, "10.0.0.8:7777");
  EXPECT_EQ(next.name, "room-b");
}

TEST_F(Fleet, WaitsForTheNextAddressOfItsPeople) {
  open();
  join_person();
  const size_t healthy = sidecar_->count(kHealth);
  const int64_t begun_ns = now_ns();
  std::jthread annotates([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(2500));
    sidecar_->set_annotations(R"("livegs.io/next-address": "10.0.0.8:7777")");
  });
  EXPECT_EQ(member_->leave().address, "10.0.0.8:7777");
  EXPECT_GE(seconds_from_ns(now_ns() - begun_ns), 2.5);
  EXPECT_GT(sidecar_->count(kHealth), healthy);  // or the fleet would remove it
  EXPECT_EQ(sidecar_->calls().back().what, kShutdown);
}

TEST_F(Fleet, LeavesWithoutANextAddressAfterTheLimit) {
  constexpr double kLimit_s = 2;
  open(kFleetEmpty_s, kLimit_s);
  join_person();
  const int64_t begun_ns = now_ns();
  EXPECT_EQ(member_->leave().address, "");
  EXPECT_GE(seconds_from_ns(sidecar_->last_ns(kShutdown) - begun_ns), kLimit_s);
}

TEST_F(Fleet, LeavesAtOnceWithoutPeople) {
  open();
  ASSERT_TRUE(sidecar_->wait_for(kReady));
  const int64_t begun_ns = now_ns();
  EXPECT_EQ(member_->leave().address, "");
  EXPECT_LT(seconds_from_ns(now_ns() - begun_ns), kNextAddressWait_s / 2);
}

TEST_F(Fleet, LeavesWhenItsLastPersonGoes) {
  open();
  join_person();
  std::jthread goes([&] {
    std::this_thread::sleep_for(std::chrono::seconds(1));
    people_ = 0;
  });
  const int64_t begun_ns = now_ns();
  EXPECT_EQ(member_->leave().address, "");
  EXPECT_LT(seconds_from_ns(now_ns() - begun_ns), kNextAddressWait_s);
}

TEST_F(Fleet, IgnoresANextAddressThatIsNone) {
  open();
  sidecar_->set_annotations(R"("livegs.io/next-address": "nowhere")");
  EXPECT_EQ(member_->leave().address, "");
}

TEST(AgonesReply, IsReadOrRefused) {
  const auto server = parse_game_server(R"({"object_meta": {"name": "a"}, "status": {"state": "Ready"}})");
  ASSERT_TRUE(server) << server.error().message;
  EXPECT_EQ(server->name, "a");
  EXPECT_EQ(server->state, "Ready");
  EXPECT_EQ(server->next_address, "");
  for (const char* text :
       {"", "{}", "[]", "null", R"({"object_meta": []})", R"({"object_meta": {"name": 3}})",
        R"({"object_meta": {"name": ""}})", "<html>", "{\"object_meta\""})
    EXPECT_FALSE(parse_game_server(text)) << text;
}

TEST(TickLiveness, IsDueOnlyIfTicksAdvance) {
  TickLiveness liveness(100);
  EXPECT_FALSE(liveness.due(0, 1000));  // before the first tick
  EXPECT_TRUE(liveness.due(1, 1000));
  EXPECT_FALSE(liveness.due(2, 1099));
  EXPECT_TRUE(liveness.due(2, 1100));
  EXPECT_FALSE(liveness.due(2, 10'000));
  EXPECT_TRUE(liveness.due(3, 10'001));
  TickLiveness none(0);
  EXPECT_FALSE(none.due(9, 9));
}

TEST(SceneLabel, IsEqualForEqualScenesOnly) {
  v1::Scene scene;
  scene.add_objects()->set_name("cup");
  const std::string label = scene_label(scene);
  EXPECT_EQ(label.size(), 16u);
  EXPECT_EQ(label, scene_label(v1::Scene(scene)));
  scene.mutable_objects(0)->set_name("mug");
  EXPECT_NE(label, scene_label(scene));
}

}  // namespace
}  // namespace livegs
