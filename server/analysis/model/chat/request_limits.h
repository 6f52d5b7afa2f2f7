// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>

// Whether and when an endpoint may be asked again; how often is a TokenBucket. Plain state machines over a
// clock that the caller reads; not synchronised.

namespace livegs {

// Closed: requests pass. Open: none does until a moment. Then one is let through; its success closes the
// breaker, its failure opens it again.
class CircuitBreaker {
 public:
  explicit CircuitBreaker(int failures_to_open, double open_s) : limit_(failures_to_open), open_s_(open_s) {}

  bool try_pass(std::int64_t now_ns);
  void succeed();
  void fail(std::int64_t now_ns, const std::string& reason);                 // one of several in a row
  void open(std::int64_t now_ns, double open_s, const std::string& reason);  // at once: no money, key refused
  void give_up_probe() { probing_ = false; }  // the request that was let through ended without a verdict

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

// The wait before try number `attempt` (0 is the first repeat): full jitter, uniform in 0 … min(cap, base
// 2^attempt) for `unit` in 0 … 1; never less than what Retry-After said. Marc Brooker, Exponential Backoff
// and Jitter (AWS, 2015).
double backoff_s(int attempt, double base_s, double cap_s, double unit, double retry_after_s);

}  // namespace livegs
