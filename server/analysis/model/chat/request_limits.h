// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

// Decides if and when an endpoint may be called again; the rate is limited by a TokenBucket. State machines
// over a clock value from the caller; not synchronised.

namespace livegs {

// Closed: requests pass. Open: requests are blocked until a deadline. Then one probe passes; its success
// closes the breaker, its failure opens it again.
class CircuitBreaker {
 public:
  explicit CircuitBreaker(int failures_to_open, double open_s) : limit_(failures_to_open), open_s_(open_s) {}

  bool try_pass(std::int64_t now_ns);
  void succeed();
  void fail(std::int64_t now_ns, const std::string& reason);  // counts one consecutive failure
  void open(std::int64_t now_ns, double open_s,
            const std::string& reason);       // opens at once: no credit, key refused
  void give_up_probe() { probing_ = false; }  // the probe ended without a verdict

  bool is_open() const { return opened_; }
  const std::string& reason() const { return reason_; }
  double seconds_left(std::int64_t now_ns) const;

 private:
  int limit_, failures_ = 0;
  double open_s_;
  bool opened_ = false, probing_ = false;
  std::int64_t until_ns_ = 0;
  std::string reason_;
};

// Wait before retry `attempt` (0 is the first): full jitter, uniform in 0 … min(cap, base 2^attempt) for
// `unit` in 0 … 1; at least `retry_after_s`. Marc Brooker, Exponential Backoff and Jitter (AWS, 2015).
double backoff_s(int attempt, double base_s, double cap_s, double unit, double retry_after_s);

}  // namespace livegs
