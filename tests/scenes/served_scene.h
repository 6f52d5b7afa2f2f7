// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "scenes/box_scene.h"
#include "session/rpc/grpc_server.h"
#include "session/simulation/simulation_loop.h"

namespace livegs {

// An in-process server that simulates one scene from construction to destruction.
class ServedScene {
 public:
  explicit ServedScene(Scene scene, std::function<void(const Scene&)> observe = {}) {
    auto listening = GrpcServer::listen("127.0.0.1:0");
    EXPECT_TRUE(listening) << listening.error().message;
    server = std::move(*listening);
    loop = std::make_unique<SimulationLoop>(std::move(scene), server->ticks(),
                                            [this, observe](const Scene& now) {
                                              tick = now.world().tick();
                                              if (observe) observe(now);
                                            });
    server->open(loop->scene(), *loop);
    loop->start();
  }
  ~ServedScene() {
    server->shut_down("test finished");
    loop->stop();
  }
  int port() const { return server->port(); }

  std::unique_ptr<GrpcServer> server;
  std::unique_ptr<SimulationLoop> loop;
  std::atomic<uint64_t> tick{0};  // the newest simulated tick
};

}  // namespace livegs
