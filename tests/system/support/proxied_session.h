// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "client/stream/session/sink_log.h"
#include "core/clock.h"
#include "core/percentile.h"
#include "patience.h"
#include "scenes/served_scene.h"
#include "stream/session/session_client.h"
#include "system/support/fault_proxy.h"
#include "system/support/join_server.h"

namespace livegs {

inline constexpr int kNobody = 1;  // a port that refuses connections

// A client of a served scene, connected through a FaultProxy.
class ProxiedSession : public ::testing::Test {
 protected:
  void start(Scene scene, const ConnectOptions& options = patient(),
             std::function<void(const Scene&)> observe = {}) {
    served_ = std::make_unique<ServedScene>(std::move(scene), std::move(observe));
    proxy_ = std::make_unique<FaultProxy>(served_->port());
    client_ = join(proxy_->port(), options);
    ASSERT_TRUE(client_);
    client_->start(sink_);
    ASSERT_TRUE(sink_.wait_frames(5));
  }
  void start() { start(box_scene()); }
  // Stops the client before the sink is destroyed, also after a failed assertion.
  ~ProxiedSession() override { client_.reset(); }

  std::unique_ptr<ServedScene> served_;
  std::unique_ptr<FaultProxy> proxy_;
  SinkLog sink_;
  std::unique_ptr<SessionClient> client_;
};

// The age of each frame on arrival, ms. Requires that both ends use the same clock.
inline std::vector<double> ages_ms(std::span<const ReceivedFrame> frames) {
  std::vector<double> ages;
  for (const ReceivedFrame& frame : frames)
    ages.push_back(milliseconds_from_ns(frame.received_ns - frame.stepped_ns));
  return ages;
}

// The difference between the 95th and the 5th percentile of ages.
inline double spread_ms(std::span<const ReceivedFrame> frames) {
  const std::vector<double> ages = ages_ms(frames);
  return percentile(ages, 0.95) - percentile(ages, 0.05);
}

inline int64_t longest_gap_ns(std::span<const ReceivedFrame> frames) {
  int64_t gap_ns = 0;
  for (size_t i = 1; i < frames.size(); ++i)
    gap_ns = std::max(gap_ns, frames[i].received_ns - frames[i - 1].received_ns);
  return gap_ns;
}

// Expects an unbroken stream, unless the machine paused for the second after which a client reconnects.
inline void expect_unbroken(const SinkLog::State& state) {
  if (longest_gap_ns(state.frames) < 900'000'000) {
    EXPECT_TRUE(state.lost.empty()) << state.lost.front();
  }
}

inline void expect_in_order(std::span<const ReceivedFrame> frames) {
  for (size_t i = 1; i < frames.size(); ++i) EXPECT_GT(frames[i].tick, frames[i - 1].tick);
}

}  // namespace livegs
