// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace livegs {

// One message to the server and one back: sent and received by the client's clock, heard and answered by the
// server's (NTP's T1 to T4). The answer need not follow at once.
struct ClockSample {
  int64_t sent_ns = 0;
  int64_t heard_ns = 0;
  int64_t answered_ns = 0;
  int64_t received_ns = 0;
};

// How much the server's clock is ahead of the client's. No message travels in less than no time, so each one
// up is an upper bound of the offset, heard - sent, and each one down a lower bound, answered - received;
// queues only make them looser. The estimate lies midway between the tightest of the last ten seconds, each
// loosened by what two clocks may have drifted apart since. Without drift, and where both came with the same
// round trip, that is the sample of the lowest round trip (RFC 5905, section 10); with jitter the two
// directions need not be quick at once. Not locked.
class ClockOffset {
 public:
  // Quartz of computers: RFC 5905 has 15 parts in a million for a disciplined clock; cheap ones reach 200.
  static constexpr double kMaxDrift = 200e-6;
  static constexpr int64_t kWindow_ns = 10'000'000'000;

  void add(const ClockSample& sample);

  struct Estimate {
    int64_t offset_ns = 0;  // server's clock minus the client's, now
    int64_t uncertainty_ns =
        0;  // it is off by no more, as long as the clocks drift by no more than kMaxDrift
  };
  std::optional<Estimate> at(int64_t client_ns) const;

 private:
  // The tightest bound first, then those that will be the tightest once the ones before them have gone out of
  // the window: all loosen alike, so what is looser than a younger one never counts again.
  struct Bound {
    int64_t client_ns = 0;  // when it was taken
    int64_t value_ns = 0;   // of the offset for the upper bound, of minus the offset for the lower
  };
  using Bounds = std::deque<Bound>;
  static void tighten(Bounds& bounds, const Bound& bound);
  static int64_t loosened(const Bound& bound, int64_t client_ns);

  Bounds upper_, lower_;
};

}  // namespace livegs
