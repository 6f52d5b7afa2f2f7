// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <random>
#include <thread>

#include "core/clock.h"
#include "scenes/box_scene.h"
#include "session/rpc/grpc_server.h"
#include "session/sessions/session_table.h"

namespace livegs {

// Sends precomputed frames of incompressible noise at 90 Hz, without a simulation. A frame has about 6 bytes
// per node. With `boxes`, the nodes belong to that number of objects on a ring of radius 4 m around the
// origin, of which a client at the origin sees a part; otherwise to one object that is visible from
// everywhere.
class NoiseServer {
 public:
  explicit NoiseServer(size_t nodes, ServerSecurity* security = nullptr, size_t clients = kDefaultSessions,
                       size_t boxes = 0)
      : scene_(box_scene()), ring_(boxes, *scene_.find("box")) {
    auto listening = GrpcServer::listen("127.0.0.1:0", security);
    EXPECT_TRUE(listening) << listening.error().message;
    server = std::move(*listening);
    server->admit(clients);
    std::vector<const SceneObject*> shown;
    for (SceneObject& box : ring_) {
      box.id = kFirstBox + static_cast<uint32_t>(shown.size());
      shown.push_back(&box);
    }
    if (shown.empty())
      server->open(scene_, nobody_);
    else
      server->open("ring", 90, shown, nobody_);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<float> place(-0.9f, 0.9f);
    for (auto& objects : frames_) {
      objects.resize(std::max<size_t>(1, boxes));
      for (size_t k = 0; k < objects.size(); ++k) {
        ObjectDrivers& object = objects[k];
        object.object_id = boxes > 0 ? ring_[k].id : 1;
        object.kind = DriverKind::Lattice;
        const float angle_rad =
            2 * static_cast<float>(M_PI * static_cast<double>(k) / static_cast<double>(objects.size()));
        const Eigen::Vector3f middle =
            (boxes > 0 ? 4.0f : 0.0f) * Eigen::Vector3f(std::sin(angle_rad), 0, -std::cos(angle_rad));
        for (size_t i = 0; i < nodes / objects.size(); ++i)
          object.positions_m.push_back(middle + Eigen::Vector3f(place(random), place(random), place(random)) *
                                                    (boxes > 0 ? 0.2f : 1.0f));
      }
    }
    thread_ = std::thread([this] { run(); });
  }
  ~NoiseServer() {
    stopping_ = true;
    thread_.join();
    server->shut_down("the test is over");
  }
  int port() const { return server->port(); }

  std::unique_ptr<GrpcServer> server;
  std::atomic<uint64_t> newest{0};  // tick

 private:
  class Nobody final : public InputSink {
    void on_input(SessionNumber, std::span<const InputSample>) override {}
    void on_session_closed(SessionNumber) override {}
  };

  void run() {
    int64_t due_ns = now_ns();
    for (uint64_t tick = 1; !stopping_; ++tick) {
      TickResult stepped;
      stepped.drivers.tick = tick;
      stepped.drivers.simulated_ns = static_cast<int64_t>(tick) * 11'111'111;
      stepped.drivers.objects = frames_[tick % frames_.size()];
      stepped.stepped_ns = now_ns();
      server->ticks().publish(std::move(stepped));
      newest = tick;
      sleep_until_ns(due_ns += 11'111'111);
    }
  }

  static constexpr uint32_t kFirstBox = 100;
  Scene scene_;
  std::vector<SceneObject> ring_;
  Nobody nobody_;
  std::array<std::vector<ObjectDrivers>, 31> frames_;  // one per tick, in turn
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace livegs
