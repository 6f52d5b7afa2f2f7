// SPDX-License-Identifier: Apache-2.0
#include "session/live/run_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "scenes/box_scene.h"
#include "server/session/simulation/tick_log.h"

namespace livegs {
namespace {

using Ticks = std::vector<TickResult>;

constexpr uint32_t kBox = 2;  // the rendered floor is object 1

// A box that falls from five metres.
Scene falling_scene(uint32_t first_object_id = 1) {
  v1::Scene file;
  const auto parsed = google::protobuf::util::JsonStringToMessage(R"({
    "environment": { "colliders": [ { "plane": {} } ] },
    "objects": [
      { "name": "box", "shape": { "box": { "size_m": [0.2, 0.2, 0.2] } }, "pose": { "position_m": [0, 5, 0] },
        "physics": { "behavior": "RIGID", "mass_kg": 2 } } ] })",
                                                                  &file);
  EXPECT_TRUE(parsed.ok());
  SceneOptions options;
  options.first_object_id = first_object_id;
  auto scene = Scene::build(file, ".", "falling", options);
  EXPECT_TRUE(scene) << scene.error().message;
  return std::move(*scene);
}

class RunControllerTest : public ::testing::Test {
 protected:
  v1::ControlRunRequest pause(bool paused) {
    v1::ControlRunRequest request;
    request.set_pause(paused);
    return request;
  }
  v1::ControlRunRequest step(uint32_t ticks) {
    v1::ControlRunRequest request;
    request.set_step_ticks(ticks);
    return request;
  }
  v1::ControlRunRequest reset() {
    v1::ControlRunRequest request;
    request.set_reset(true);
    return request;
  }
  size_t wait_ticks(size_t more) {
    const size_t before = log_.ticks().size();
    EXPECT_TRUE(log_.wait([&](const Ticks& ticks) { return ticks.size() >= before + more; }));
    return log_.ticks().size();
  }
  TickLog log_;
  SimulationLoop loop_{falling_scene(), log_};
  RunController run_{loop_, [](uint32_t first_id) -> Result<Scene> { return falling_scene(first_id); }};
};

TEST_F(RunControllerTest, PausedSceneTicksWithoutMotion) {
  loop_.start();
  wait_ticks(3);
  ASSERT_TRUE(run_.control(pause(true)));
  const size_t begin = wait_ticks(2);
  wait_ticks(10);
  const Ticks halted = log_.ticks();
  for (size_t i = begin; i < halted.size(); ++i) {
    EXPECT_TRUE(halted[i].run.paused);
    EXPECT_EQ(halted[i].drivers.tick, halted[i - 1].drivers.tick + 1);
    EXPECT_EQ(halted[i].drivers.simulated_ns, halted[begin].drivers.simulated_ns);
    EXPECT_EQ(middle_of(halted[i].drivers, kBox), middle_of(halted[begin].drivers, kBox));
  }
  ASSERT_TRUE(run_.control(pause(false)));
  wait_ticks(5);
  loop_.stop();
  EXPECT_LT(middle_of(log_.ticks().back().drivers, kBox).y(), middle_of(halted.back().drivers, kBox).y());
}

TEST_F(RunControllerTest, StepsAdvanceByTheirTicks) {
  ASSERT_TRUE(run_.control(pause(true)));
  loop_.start();
  wait_ticks(3);
  EXPECT_EQ(log_.ticks().back().drivers.simulated_ns, 0);
  ASSERT_TRUE(run_.control(step(7)));
  ASSERT_TRUE(
      log_.wait([](const Ticks& ticks) { return ticks.back().drivers.simulated_ns > 7e9 / 90 - 1e6; }));
  wait_ticks(5);
  loop_.stop();
  EXPECT_NEAR(static_cast<double>(log_.ticks().back().drivers.simulated_ns), 7e9 / 90,
              10);  // rounded to nanoseconds
  EXPECT_TRUE(log_.ticks().back().run.paused);
}

TEST_F(RunControllerTest, ResetRestoresTheLoadedScene) {
  loop_.start();
  ASSERT_TRUE(log_.wait(
      [](const Ticks& ticks) { return !ticks.empty() && middle_of(ticks.back().drivers, kBox).y() < 4.9; }));
  ASSERT_TRUE(run_.control(reset()));
  ASSERT_TRUE(log_.wait([](const Ticks& ticks) { return ticks.back().run.resets == 1; }));
  wait_ticks(3);
  loop_.stop();
  const Ticks ticks = log_.ticks();
  const auto reset_tick =
      std::find_if(ticks.begin(), ticks.end(), [](const TickResult& tick) { return tick.run.resets == 1; });
  // All objects are replaced in one tick, with unused ids.
  ASSERT_EQ(reset_tick->added.size(), 2u);
  EXPECT_EQ(reset_tick->added[1].name, "box");
  EXPECT_EQ(reset_tick->removed, (std::vector<uint32_t>{1, kBox}));
  const uint32_t id = reset_tick->added[1].id;
  EXPECT_GT(id, 1u << 19);
  EXPECT_EQ(reset_tick->drivers.objects.size(), 2u);
  // It has fallen for at most one tick, g / rate².
  EXPECT_NEAR(middle_of(reset_tick->drivers, id).y(), 5, 9.81 / 8100);
  EXPECT_NEAR(reset_tick->run.simulated_s, 1.0 / 90, 1e-8);
  for (auto tick = ticks.begin() + 1; tick != ticks.end(); ++tick) {
    EXPECT_EQ(tick->drivers.tick, (tick - 1)->drivers.tick + 1);
    EXPECT_GT(tick->drivers.simulated_ns, (tick - 1)->drivers.simulated_ns);
  }
}

TEST_F(RunControllerTest, FailedResetReportsWhyAndTheSceneContinues) {
  RunController broken(loop_, [](uint32_t) -> Result<Scene> {
    return not_found("/srv/my scenes/cup.ply: is not there any more");
  });
  loop_.start();
  ASSERT_TRUE(broken.control(reset()));
  ASSERT_TRUE(
      log_.wait([](const Ticks& ticks) { return !ticks.empty() && !ticks.back().run.message.empty(); }));
  loop_.stop();
  EXPECT_EQ(log_.ticks().back().run.message, "reset: cup.ply: is not there any more");
  EXPECT_FALSE(log_.ticks().back().run.loading);
  EXPECT_EQ(log_.ticks().back().run.resets, 0u);
}

// Running out of memory while a scene is loaded or its assets are encoded ends neither the server nor the
// scene.
TEST_F(RunControllerTest, ResetWithoutMemoryFailsAndTheSceneContinues) {
  loop_.start();
  const auto expect_reported = [&](RunController& run) {
    ASSERT_TRUE(run.control(reset()));
    ASSERT_TRUE(
        log_.wait([](const Ticks& ticks) { return !ticks.empty() && !ticks.back().run.message.empty(); }));
    EXPECT_EQ(log_.ticks().back().run.message, std::string("reset: ") + std::bad_alloc().what());
    EXPECT_FALSE(log_.ticks().back().run.loading);
    wait_ticks(3);
  };
  RunController short_of_memory(loop_, [](uint32_t) -> Result<Scene> { throw std::bad_alloc(); });
  expect_reported(short_of_memory);
  loop_.set_loading(false, "");
  ASSERT_TRUE(log_.wait([](const Ticks& ticks) { return ticks.back().run.message.empty(); }));
  RunController cannot_encode(
      loop_, [](uint32_t first_id) -> Result<Scene> { return falling_scene(first_id); },
      [](const Scene&) { throw std::bad_alloc(); });
  expect_reported(cannot_encode);
  loop_.stop();
  EXPECT_EQ(log_.ticks().back().run.resets, 0u);
}

TEST_F(RunControllerTest, RefusesInvalidRequests) {
  EXPECT_EQ(run_.control({}).error().code, ErrorCode::InvalidArgument);
  EXPECT_EQ(run_.control(step(0)).error().code, ErrorCode::InvalidArgument);
  EXPECT_EQ(run_.control(step(1001)).error().code, ErrorCode::InvalidArgument);
}

v1::Event::Force force_on(const std::string& object, const Eigen::Vector3d& force_n, double duration_s) {
  v1::Event::Force force;
  force.set_object(object);
  for (int i = 0; i < 3; ++i) force.add_point_m(0);
  for (int i = 0; i < 3; ++i) force.add_force_n(force_n[i]);
  force.set_duration_s(duration_s);
  return force;
}

// 6 N for half a second on 2 kg: 1.5 m/s, then constant.
TEST_F(RunControllerTest, ForceActsForItsDuration) {
  ASSERT_TRUE(run_.control(pause(true)));
  loop_.start();
  ASSERT_TRUE(run_.apply_force(force_on("box", {6, 0, 0}, 0.5)));
  ASSERT_TRUE(run_.control(step(75)));
  ASSERT_TRUE(log_.wait([](const Ticks& ticks) {
    return !ticks.empty() && ticks.back().drivers.simulated_ns > 75e9 / 90 - 1e6;
  }));
  loop_.stop();
  const std::vector<BodyState> bodies = loop_.scene().world().bodies();
  const BodyState box = *std::find_if(bodies.begin(), bodies.end(),
                                      [](const BodyState& body) { return body.object_id == kBox; });
  EXPECT_NEAR(box.velocity_m_s.x(), 1.5, 1e-6);  // F t / m, over 45 whole ticks
}

TEST_F(RunControllerTest, RefusesInvalidForcesByField) {
  const auto why = [&](const v1::Event::Force& force) { return run_.apply_force(force).error().message; };
  v1::Event::Force two = force_on("box", {1, 0, 0}, 1);
  two.mutable_force_n()->RemoveLast();
  EXPECT_EQ(why(two).rfind("force.force_n:", 0), 0u);
  EXPECT_EQ(why(force_on("box", {2e5, 0, 0}, 1)).rfind("force.force_n:", 0), 0u);
  EXPECT_EQ(why(force_on("box", {std::nan(""), 0, 0}, 1)).rfind("force.force_n", 0), 0u);
  EXPECT_EQ(why(force_on("box", {1, 0, 0}, 0)).rfind("force.duration_s:", 0), 0u);
  EXPECT_EQ(why(force_on("box", {1, 0, 0}, 61)).rfind("force.duration_s:", 0), 0u);
  EXPECT_EQ(why(force_on("box", {1, 0, 0}, std::nan(""))).rfind("force.duration_s:", 0), 0u);
}

}  // namespace
}  // namespace livegs
