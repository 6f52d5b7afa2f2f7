// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/session/rpc/raw_client.h"

namespace livegs {

// A client that reads and acknowledges frames without decoding them. In production, decoding runs on other
// machines.
class Listener {
 public:
  explicit Listener(int port) : raw_(port) {
    const grpc::Status status = raw_.join();
    EXPECT_TRUE(status.ok()) << status.error_message();
    raw_.open();
    thread_ = std::thread([this] {
      v1::ServerMessage message;
      while (raw_.read_any(message)) {
        if (message.tick() == 0) continue;
        tick_ = message.tick();
        ++frames_;
        raw_.acknowledge(message.tick());
      }
    });
  }
  ~Listener() {
    raw_.cancel();
    thread_.join();
    (void)raw_.finish_reading();
  }
  uint64_t tick() const { return tick_; }
  uint64_t frames() const { return frames_; }

 private:
  RawClient raw_;
  std::atomic<uint64_t> tick_{0}, frames_{0};
  std::thread thread_;
};

}  // namespace livegs
