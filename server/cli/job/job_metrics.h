// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "core/result.h"

namespace livegs {

// Progress of a job for Prometheus: GET /metrics in the text format. One thread answers one request at a
// time. (The server of prometheus-cpp gives its threads a stack that is smaller than the thread-local data of
// this program.)
class JobMetrics {
 public:
  // `address`: [HOST:]PORT with an IPv4 HOST, 127.0.0.1 by default; port 0 lets the system choose.
  static Result<std::unique_ptr<JobMetrics>> serve(const std::string& address, std::string command);
  ~JobMetrics();
  JobMetrics(const JobMetrics&) = delete;
  JobMetrics& operator=(const JobMetrics&) = delete;

  // Any thread.
  std::atomic<size_t> steps_done = 0, steps = 0, checkpoint_step = 0;

 private:
  JobMetrics() = default;
  void run(const std::stop_token& stop) const;
  std::string text() const;

  std::string command_;
  int listener_ = -1;
  std::jthread thread_;  // last: it uses all members above
};

}  // namespace livegs
