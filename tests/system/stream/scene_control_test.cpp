// SPDX-License-Identifier: Apache-2.0
// Scene control from a window, over the wire: pause, step, reset and forces.
#include "stream/session/scene_control.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>

#include "scenes/box_scene.h"
#include "session/live/run_controller.h"
#include "session/rpc/grpc_server.h"
#include "stream/session/session_client.h"

namespace livegs {
namespace {

constexpr std::chrono::seconds kPatience{60};

// Stores all received updates.
class Watcher final : public StreamSink {
 public:
  void on_lost(const std::string&) override {}
  void on_resumed(const ResumedSession&) override {}
  void on_frame(ReceivedFrame frame) override {
    std::lock_guard lock(mutex_);
    frames_.push_back(std::move(frame));
    changed_.notify_all();
  }
  void on_object_added(StreamedObject object) override {
    std::lock_guard lock(mutex_);
    added_.push_back(object.name);
    ids_.push_back(object.id);
  }
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t id) override {
    std::lock_guard lock(mutex_);
    removed_.push_back(id);
  }
  void on_draining(const std::string&) override {}

  // Waits for a frame that satisfies the condition, and returns it.
  std::optional<ReceivedFrame> wait(const std::function<bool(const ReceivedFrame&)>& wanted) {
    std::unique_lock lock(mutex_);
    const auto there = [&] { return !frames_.empty() && wanted(frames_.back()); };
    if (!changed_.wait_for(lock, kPatience, there)) return std::nullopt;
    return frames_.back();
  }
  std::vector<std::string> added() {
    std::lock_guard lock(mutex_);
    return added_;
  }
  std::vector<uint32_t> ids() {
    std::lock_guard lock(mutex_);
    return ids_;
  }
  std::vector<uint32_t> removed() {
    std::lock_guard lock(mutex_);
    return removed_;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<ReceivedFrame> frames_;
  std::vector<std::string> added_;
  std::vector<uint32_t> ids_, removed_;
};

class SceneControlTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto server = GrpcServer::listen("127.0.0.1:0");
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
    loop_ = std::make_unique<SimulationLoop>(box_scene(), server_->ticks());
    run_ = std::make_unique<RunController>(
        *loop_, [](uint32_t first_id) -> Result<Scene> { return box_scene(90, 0.2, first_id); },
        [this](Scene scene) {
          server_->encode_ahead(scene);
          loop_->replace(std::move(scene));
        });
    server_->open(loop_->scene(), *loop_);
    server_->open_run(*run_);
    loop_->start();
    const std::string address = "127.0.0.1:" + std::to_string(server_->port());
    auto client = SessionClient::join(address, {});
    ASSERT_TRUE(client) << client.error().message;
    client_ = std::move(*client);
    client_->start(watcher_);
    control_ = std::make_unique<SceneControl>(address);
  }
  void TearDown() override {
    if (client_) (void)client_->stop();
    if (server_) server_->shut_down("the test is over");
    if (loop_) loop_->stop();
    run_.reset();
  }
  Watcher watcher_;
  std::unique_ptr<GrpcServer> server_;
  std::unique_ptr<SimulationLoop> loop_;
  std::unique_ptr<RunController> run_;
  std::unique_ptr<SessionClient> client_;
  std::unique_ptr<SceneControl> control_;
};

TEST_F(SceneControlTest, FramesCarryThePauseState) {
  ASSERT_TRUE(watcher_.wait([](const ReceivedFrame& frame) { return !frame.run.paused(); }));
  v1::ControlRunRequest request;
  request.set_pause(true);
  const auto halted = control_->control_run(request);
  ASSERT_TRUE(halted) << halted.error().message;
  EXPECT_TRUE(halted->paused());
  const auto at = watcher_.wait([](const ReceivedFrame& frame) { return frame.run.paused(); });
  ASSERT_TRUE(at);
  // Frames continue while simulated time is paused.
  const auto later = watcher_.wait([&](const ReceivedFrame& frame) { return frame.tick > at->tick + 20; });
  ASSERT_TRUE(later);
  EXPECT_EQ(later->drivers->simulated_ns, at->drivers->simulated_ns);
  EXPECT_EQ(later->run.simulated_s(), at->run.simulated_s());
  request.set_step_ticks(3);
  ASSERT_TRUE(control_->control_run(request));
  EXPECT_TRUE(watcher_.wait([&](const ReceivedFrame& frame) {
    return frame.drivers->simulated_ns > at->drivers->simulated_ns + static_cast<int64_t>(2.9e9 / 90);
  }));
}

TEST_F(SceneControlTest, ResetSendsTheSceneToEveryClient) {
  ASSERT_TRUE(watcher_.wait([](const ReceivedFrame& frame) { return frame.tick > 5; }));
  std::vector<uint32_t> old_ids;
  for (const StreamedObject& object : client_->scene().objects) old_ids.push_back(object.id);
  v1::ControlRunRequest request;
  request.set_reset(true);
  ASSERT_TRUE(control_->control_run(request));
  const auto after_reset = watcher_.wait([](const ReceivedFrame& frame) { return frame.run.resets() == 1; });
  ASSERT_TRUE(after_reset);
  EXPECT_EQ(watcher_.added(), (std::vector<std::string>{"environment", "box", "cube"}));
  EXPECT_EQ(watcher_.removed(), old_ids);
  ASSERT_EQ(after_reset->drivers->objects.size(), 3u);
  for (const ObjectDrivers& object : after_reset->drivers->objects) {
    const std::vector<uint32_t> ids = watcher_.ids();
    EXPECT_NE(std::find(ids.begin(), ids.end(), object.object_id), ids.end());
  }
  // A client that joins now receives the same scene.
  auto second = SessionClient::join("127.0.0.1:" + std::to_string(server_->port()), {});
  ASSERT_TRUE(second) << second.error().message;
  ASSERT_EQ((*second)->scene().objects.size(), 3u);
  EXPECT_EQ((*second)->scene().objects[0].id, watcher_.ids()[0]);
}

TEST_F(SceneControlTest, ForceMovesItsObject) {
  const auto before = watcher_.wait([](const ReceivedFrame&) { return true; });
  ASSERT_TRUE(before);
  ASSERT_EQ(client_->scene().objects[1].name, "box");
  ASSERT_EQ(before->drivers->objects[1].object_id, client_->scene().objects[1].id);
  const auto place = [&](const ReceivedFrame& frame) {
    return frame.drivers->objects[1].poses.at(0).position_m.x();
  };
  v1::Event::Force force;
  force.set_object("box");
  for (const double number : {0.0, 0.0, 0.0}) force.add_point_m(number);
  for (const double number : {30.0, 0.0, 0.0}) force.add_force_n(number);  // friction is at most 4.9 N
  force.set_duration_s(0.5);
  const auto taken = control_->apply_force(force);
  ASSERT_TRUE(taken) << taken.error().message;
  EXPECT_TRUE(watcher_.wait([&](const ReceivedFrame& frame) { return place(frame) > place(*before) + 0.1; }));

  force.set_object("vase");
  const auto unknown = control_->apply_force(force);
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::NotFound);
  EXPECT_NE(unknown.error().message.find("box, cube"), std::string::npos) << unknown.error().message;
  force.set_object("box");
  force.set_duration_s(1e9);
  EXPECT_EQ(control_->apply_force(force).error().code, ErrorCode::InvalidArgument);
}

// A refused call gives one line, and a cancelled call ends.
TEST_F(SceneControlTest, RefusedAndCancelledCallsReturn) {
  const auto refused = control_->set_physics("box", {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::Unavailable);
  control_->cancel();
  v1::ControlRunRequest request;
  request.set_pause(true);
  EXPECT_FALSE(control_->control_run(request));
}

}  // namespace
}  // namespace livegs
