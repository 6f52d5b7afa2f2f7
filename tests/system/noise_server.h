// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "core/clock.h"
#include "server/session/box_scene.h"
#include "session/live_server.h"
#include "session/session_table.h"

namespace livegs {

// Sends frames of noise, which nothing compresses: `nodes` times six bytes and a little, 90 times a second, of no simulation.
// They are made beforehand; making one takes as long as encoding it.
class NoiseServer {
 public:
  explicit NoiseServer(size_t nodes, ServerSecurity* security = nullptr, size_t clients = kUsualSessions) : scene_(box_scene()) {
    auto listening = LiveServer::listen("127.0.0.1:0", security);
    EXPECT_TRUE(listening) << listening.error().message;
    server = std::move(*listening);
    server->admit(clients);
    server->open(scene_, nobody_);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<float> place(-0.9f, 0.9f);
    for (ObjectDrivers& object : objects_) {
      object.object_id = 1;
      object.kind = DriverKind::Lattice;
      for (size_t i = 0; i < nodes; ++i) object.positions_m.emplace_back(place(random), place(random), place(random));
    }
    thread_ = std::thread([this] { run(); });
  }
  ~NoiseServer() {
    stopping_ = true;
    thread_.join();
    server->shut_down("the noise is over");
  }
  int port() const { return server->port(); }

  std::unique_ptr<LiveServer> server;
  std::atomic<uint64_t> newest{0};  // tick

 private:
  class Nobody final : public InputSink {
    void hear(SessionNumber, std::span<const InputSample>) override {}
    void forget(SessionNumber) override {}
  };

  void run() {
    int64_t due_ns = now_ns();
    for (uint64_t tick = 1; !stopping_; ++tick) {
      SteppedTick stepped;
      stepped.drivers.tick = tick;
      stepped.drivers.simulated_ns = static_cast<int64_t>(tick) * 11'111'111;
      stepped.drivers.objects.push_back(objects_[tick % objects_.size()]);
      stepped.stepped_ns = now_ns();
      server->ticks().publish(std::move(stepped));
      newest = tick;
      sleep_until_ns(due_ns += 11'111'111);
    }
  }

  Scene scene_;
  Nobody nobody_;
  std::array<ObjectDrivers, 31> objects_;  // one for each tick, in turn
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace livegs
