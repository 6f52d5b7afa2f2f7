// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "scenes/box_scene.h"
#include "server/session/simulation/tick_log.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {
namespace {

using Ticks = std::vector<TickResult>;

std::array<InputSample, 1> one(const InputSample& sample) { return {sample}; }

TEST(SimulationLoop, PublishesEveryTickInOrder) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 20; }));
  loop.stop();
  const Ticks ticks = log.ticks();
  for (size_t i = 0; i < ticks.size(); ++i) EXPECT_EQ(ticks[i].drivers.tick, i + 1);
  EXPECT_EQ(loop.summary().ticks, ticks.size());
}

TEST(SimulationLoop, NeverRunsAheadOfItsSchedule) {
  TickLog log;
  SimulationLoop loop(box_scene(200), log);
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 100; }));
  loop.stop();
  const Ticks ticks = log.ticks();
  // Tick n is due n periods after tick 0. The schedule catches up by at most two periods, then slips. So n
  // ticks take at least n periods less three, including the current one.
  const int64_t period_ns = 5'000'000;
  for (size_t begin : {size_t{0}, size_t{10}, size_t{50}}) {
    for (size_t end = begin + 1; end < ticks.size(); ++end) {
      EXPECT_GE(ticks[end].stepped_ns - ticks[begin].stepped_ns,
                (static_cast<int64_t>(end - begin) - kMaxPeriodsBehind - 1) * period_ns);
    }
  }
}

// A ray from in front of an object moves up and lifts its middle. `name` is at x, on the floor.
void expect_pull_lifts(const char* name, double x) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  const uint32_t id = loop.scene().find(name)->id;
  const Eigen::Vector3d from_m(x, 0.1, 1.0);
  loop.on_input(1, one(hand_sample(1, from_m, 1.0f)));
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return !ticks.empty(); }));
  const double start_y = middle_of(log.ticks().front().drivers, id).y();
  // Half a metre up, a centimetre a tick; each sample resets the input timeout.
  for (uint64_t step = 1; step <= 50; ++step) {
    const size_t seen = log.ticks().size();
    loop.on_input(1, one(hand_sample(
                         1 + step, from_m + Eigen::Vector3d(0, 0.01 * static_cast<double>(step), 0), 1.0f)));
    ASSERT_TRUE(log.wait([&](const Ticks& ticks) { return ticks.size() > seen; }));
  }
  uint64_t sequence = 51;
  const auto lifted = [&](const Ticks& ticks) {
    loop.on_input(1, one(hand_sample(++sequence, from_m + Eigen::Vector3d(0, 0.5, 0), 1.0f)));
    return middle_of(ticks.back().drivers, id).y() > start_y + 0.25;
  };
  EXPECT_TRUE(log.wait(lifted)) << name << " at " << middle_of(log.ticks().back().drivers, id).transpose();
  const TickResult held = log.ticks().back();
  ASSERT_EQ(held.hands.size(), 1u);
  EXPECT_TRUE(held.hands[0].hands[1].holding);
  EXPECT_EQ(held.hands[0].hands[1].object_id, id);

  // The trigger is released: it falls back to the floor.
  loop.on_input(1, one(hand_sample(++sequence, from_m, 0.0f)));
  EXPECT_TRUE(
      log.wait([&](const Ticks& ticks) { return middle_of(ticks.back().drivers, id).y() < start_y + 0.05; }));
  EXPECT_FALSE(log.ticks().back().hands[0].hands[1].holding);
}

TEST(SimulationLoop, RayLiftsARigidBox) { expect_pull_lifts("box", -0.5); }
TEST(SimulationLoop, RayLiftsASoftCube) { expect_pull_lifts("cube", 0.5); }

TEST(SimulationLoop, RisingEdgeShootsOneBall) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  const Eigen::Vector3d from_m(0, 0.5, 1);
  // Samples repeat, as on the wire; the button stays down for the last three.
  const std::array<InputSample, 4> samples = {
      hand_sample(1, from_m, 0, false), hand_sample(2, from_m, 0, true), hand_sample(3, from_m, 0, true),
      hand_sample(4, from_m, 0, true)};
  loop.on_input(1, samples);
  loop.on_input(1, samples);
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 10; }));
  loop.stop();
  size_t added = 0;
  const Ticks ticks = log.ticks();
  for (const TickResult& tick : ticks) added += tick.added.size();
  EXPECT_EQ(added, 1u);
  ASSERT_EQ(ticks[0].added.size(), 1u);
  const uint32_t ball = ticks[0].added[0].id;
  // Along -z at kBallSpeed_m_s, for the nine ticks from the first to the tenth; gravity acts across.
  const double travelled = middle_of(ticks[0].drivers, ball).z() - middle_of(ticks[9].drivers, ball).z();
  EXPECT_NEAR(travelled, kBallSpeed_m_s * 9 / 90, 1e-3);
}

// Presses faster than the limit are shot one after the other, each along the ray of its press.
TEST(SimulationLoop, ShotsAreLimitedInTime) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  std::vector<InputSample> flicker;
  for (uint64_t i = 1; i <= 6; ++i) {
    const double x_m = 0.5 * static_cast<double>(i / 2);
    flicker.push_back(hand_sample(i, {x_m, 0.5, 1}, 0, i % 2 == 0));
  }
  loop.on_input(1, flicker);
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 30; }));
  loop.stop();
  EXPECT_EQ(loop.summary().shots, 3u);
  const Ticks ticks = log.ticks();
  std::vector<size_t> shot_in;
  for (size_t i = 0; i < ticks.size(); ++i) {
    for (const SceneObject& ball : ticks[i].added) {
      shot_in.push_back(i);
      EXPECT_NEAR(middle_of(ticks[i].drivers, ball.id).x(), 0.5 * static_cast<double>(shot_in.size()), 1e-3);
    }
  }
  ASSERT_EQ(shot_in.size(), 3u);
  // kMinShotInterval_s is nine ticks, or ten by rounding.
  EXPECT_NEAR(static_cast<double>(shot_in[1] - shot_in[0]), 9.5, 0.5);
  EXPECT_NEAR(static_cast<double>(shot_in[2] - shot_in[1]), 9.5, 0.5);
}

TEST(SimulationLoop, WaitingShotsAreLimitedInNumber) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  std::vector<InputSample> flicker;
  for (uint64_t i = 1; i <= 60; ++i) flicker.push_back(hand_sample(i, {0, 0.5, 1}, 0, i % 2 == 0));
  loop.on_input(1, flicker);
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 10 * (kMaxWaitingShots + 2); }));
  loop.stop();
  EXPECT_EQ(loop.summary().shots, kMaxWaitingShots);
}

TEST(SimulationLoop, ClosedSessionReleasesItsObject) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  loop.on_input(1, one(hand_sample(1, {-0.5, 0.1, 1}, 1.0f)));
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) {
    return !ticks.empty() && !ticks.back().hands.empty() && ticks.back().hands[0].hands[1].holding;
  }));
  loop.on_session_closed(1);
  EXPECT_TRUE(log.wait([](const Ticks& ticks) { return ticks.back().hands.empty(); }));
}

TEST(SimulationLoop, SilentSessionReleasesItsObject) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  loop.on_input(1, one(hand_sample(1, {-0.5, 0.1, 1}, 1.0f)));
  loop.start();
  const auto holds = [](const Ticks& ticks) {
    return !ticks.empty() && !ticks.back().hands.empty() && ticks.back().hands[0].hands[1].holding;
  };
  ASSERT_TRUE(log.wait(holds));
  ASSERT_TRUE(log.wait([&](const Ticks& ticks) { return !holds(ticks); }));
  EXPECT_EQ(log.ticks().back().hands.size(), 1u);  // the session still exists
}

// A hand that stayed closed while its client was silent grabs nothing afterwards: it must open first.
TEST(SimulationLoop, ReturningClosedHandGrabsNothing) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  const Eigen::Vector3d from_m(-0.5, 0.1, 1);
  loop.on_input(1, one(hand_sample(1, from_m, 1.0f)));
  loop.start();
  const auto holds = [](const Ticks& ticks) {
    return !ticks.empty() && !ticks.back().hands.empty() && ticks.back().hands[0].hands[1].holding;
  };
  ASSERT_TRUE(log.wait(holds));
  ASSERT_TRUE(log.wait([&](const Ticks& ticks) { return !holds(ticks); }));
  uint64_t sequence = 1;
  const auto send = [&](float trigger) {
    loop.on_input(1, one(hand_sample(++sequence, from_m, trigger)));
    return log.wait([&](const Ticks& ticks) { return ticks.back().hands[0].input_sequence == sequence; });
  };
  ASSERT_TRUE(send(1.0f));
  EXPECT_FALSE(holds(log.ticks()));
  ASSERT_TRUE(send(0.0f));
  ASSERT_TRUE(send(1.0f));
  EXPECT_TRUE(holds(log.ticks()));
}

TEST(SimulationLoop, AppliesASampleAtItsTargetTick) {
  TickLog log;
  SimulationLoop loop(box_scene(), log);
  std::array<InputSample, 4> samples;
  for (size_t i = 0; i < samples.size(); ++i) samples[i] = hand_sample(i + 1, {-0.5, 0.1, 1}, 1.0f);
  samples[0].for_tick = 5;
  samples[1].for_tick = 7;
  samples[2].for_tick = 6;              // an earlier target tick still waits for the samples before it
  samples[3].for_tick = 1'000'000'000;  // implausible, applied at the next tick
  loop.on_input(1, samples);
  loop.start();
  ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 10; }));
  loop.stop();
  const Ticks ticks = log.ticks();
  for (const auto& [tick, sequence] : {std::pair{4, 0}, {5, 1}, {6, 1}, {7, 4}, {8, 4}}) {
    const TickResult& stepped = ticks.at(static_cast<size_t>(tick) - 1);
    ASSERT_EQ(stepped.drivers.tick, static_cast<uint64_t>(tick));
    const uint64_t applied = stepped.hands.empty() ? 0 : stepped.hands[0].input_sequence;
    EXPECT_EQ(applied, static_cast<uint64_t>(sequence)) << "at tick " << tick;
  }
  EXPECT_TRUE(ticks.at(4).hands.at(0).hands[1].holding);
}

// Actions of two clients in one tick are applied in the order of joining, not of arrival.
TEST(SimulationLoop, ArrivalOrderOfClientsDoesNotMatter) {
  std::vector<Ticks> runs;
  for (const bool swapped : {false, true}) {
    TickLog log;
    SimulationLoop loop(box_scene(), log);
    std::array<std::vector<InputSample>, 2> samples;
    for (uint64_t i = 1; i <= 20; ++i) {
      for (int who = 0; who < 2; ++who) {
        InputSample sample =
            hand_sample(i, {-0.5, 0.1 + 0.004 * static_cast<double>(i) * (who + 1), 0.5}, 1.0f);
        sample.hands[1].grip.position_m = {-0.5 + 0.1 * who, 0.1 + 0.01 * static_cast<double>(i), 0};
        sample.hands[1].squeeze = who == 1 ? 1.0f : 0.0f;  // one pulls with the ray, the other grabs
        sample.for_tick = i;
        samples[static_cast<size_t>(who)].push_back(sample);
      }
    }
    for (const size_t who : swapped ? std::array<size_t, 2>{1, 0} : std::array<size_t, 2>{0, 1}) {
      loop.on_input(who + 1, samples[who]);
    }
    loop.start();
    ASSERT_TRUE(log.wait([](const Ticks& ticks) { return ticks.size() >= 25; }));
    loop.stop();
    runs.push_back(log.ticks());
  }
  for (size_t i = 0; i < 25; ++i) {
    for (size_t o = 0; o < runs[0][i].drivers.objects.size(); ++o) {
      const ObjectDrivers &a = runs[0][i].drivers.objects[o], &b = runs[1][i].drivers.objects[o];
      ASSERT_EQ(a.poses.size(), b.poses.size());
      for (size_t p = 0; p < a.poses.size(); ++p) ASSERT_EQ(a.poses[p].position_m, b.poses[p].position_m);
      ASSERT_EQ(a.positions_m, b.positions_m);
    }
  }
  EXPECT_TRUE(runs[0][15].hands.at(0).hands[1].holding);
  EXPECT_TRUE(runs[0][15].hands.at(1).hands[1].grabbed);
}

}  // namespace
}  // namespace livegs
