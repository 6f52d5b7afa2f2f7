// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

#include "core/clock.h"
#include "core/percentile.h"

namespace livegs {

// Measures how late this machine wakes a sleeping thread (p99), to correct bounds of timing tests for other
// load.
class Lateness {
 public:
  // Upper limit of the correction per wait, two ticks at 90 Hz. A larger correction would hide queueing in
  // the program under test.
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
  // The time that `waits` successive waits may lose to other load.
  double allowance_ms(int waits) { return waits * std::min(p99_ms(), kMaxAllowed_ms); }
  ~Lateness() { (void)p99_ms(); }

 private:
  std::atomic<bool> stopping_{false};
  std::vector<double> late_ms_{0};
  std::thread thread_;
};

}  // namespace livegs
