// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <condition_variable>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "core/clock.h"
#include "scenes/box_scene.h"
#include "server/session/rpc/raw_client.h"
#include "session/rpc/grpc_server.h"

namespace livegs {

// Records the input of sessions.
class InputLog final : public InputSink {
 public:
  void on_input(SessionNumber session, std::span<const InputSample> samples) override {
    std::lock_guard lock(mutex_);
    for (const InputSample& sample : samples) received_.emplace_back(session, sample);
    changed_.notify_all();
  }
  void on_session_closed(SessionNumber session) override {
    std::lock_guard lock(mutex_);
    forgotten_.push_back(session);
    changed_.notify_all();
  }
  bool wait_heard(size_t samples) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return received_.size() >= samples; });
  }
  bool wait_forgotten(size_t sessions) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return forgotten_.size() >= sessions; });
  }
  size_t received() const {
    std::lock_guard lock(mutex_);
    return received_.size();
  }
  size_t forgotten() const {
    std::lock_guard lock(mutex_);
    return forgotten_.size();
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<std::pair<SessionNumber, InputSample>> received_;
  std::vector<SessionNumber> forgotten_;
};

class GrpcServerTest : public ::testing::Test {
 protected:
  GrpcServerTest() : scene_(box_scene()) {
    auto server = GrpcServer::listen("127.0.0.1:0");
    EXPECT_TRUE(server) << server.error().message;
    server_ = std::move(*server);
  }
  void open() { server_->open(scene_, inputs_); }
  TickResult tick(uint64_t number) const {
    TickResult stepped;
    stepped.drivers = scene_.world().drivers();
    stepped.drivers.tick = number;
    stepped.stepped_ns = now_ns();
    stepped.step_ms = 1.5;
    return stepped;
  }
  // Clients receive it with its own tick: the asset of balls is encoded before clients may join.
  const SceneObject& shoot() { return scene_.shoot_ball({0, 1, 1}, {0, 0, -6}); }
  // The box moves in each tick: a scene at rest has no frame in most of them (kRestInterval_ns).
  void publish(uint64_t number) {
    TickResult moved = tick(number);
    for (ObjectDrivers& object : moved.drivers.objects) {
      if (object.kind == DriverKind::Rigid && !object.poses.empty())
        object.poses.front().position_m.x() += 1e-3 * static_cast<double>(number % 100);
    }
    server_->ticks().publish(std::move(moved));
  }

  Scene scene_;
  InputLog inputs_;  // must outlive the server
  std::unique_ptr<GrpcServer> server_;
};

}  // namespace livegs
