// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "core/percentile.h"

namespace livegs {

// How much later than told this machine wakes a thread up, the worst of a hundred times: what a wait costs
// beside other work.
class Lateness {
 public:
  // What one wait is allowed at most, so that no machine is late enough for a program that queues or pauses:
  // two ticks of 90 Hz.
  static constexpr double kMaxAllowed_ms = 2e3 / 90;

  Lateness()
      : thread_([this] {
          while (!stopping_) {
            const int64_t due_ns = now_ns() + 5'000'000;
            sleep_until_ns(due_ns);
            late_ms_.push_back(milliseconds_from_ns(now_ns() - due_ns));
          }
        }) {}
  double p99_ms() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
    return percentile(late_ms_, 0.99);
  }
  // What so many waits in a row may take beside other work.
  double allowance_ms(int waits) { return waits * std::min(p99_ms(), kMaxAllowed_ms); }
  ~Lateness() { (void)p99_ms(); }

 private:
  std::atomic<bool> stopping_{false};
  std::vector<double> late_ms_{0};
  std::thread thread_;
};

}  // namespace livegs
