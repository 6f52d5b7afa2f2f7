// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

namespace livegs {

// A message to the server and its reply, with the NTP timestamps T1 to T4. sent_ns and received_ns are times
// of the client's clock, server_received_ns and server_sent_ns of the server's. The reply may be delayed.
struct ClockSample {
  int64_t sent_ns = 0;
  int64_t server_received_ns = 0;
  int64_t server_sent_ns = 0;
  int64_t received_ns = 0;
};

// Estimates how far the server's clock is ahead of the client's. Travel times are positive. A message to the
// server therefore gives an upper bound of the offset, server_received - sent, and a reply a lower bound,
// server_sent - received. Queuing loosens both. The estimate is midway between the tightest bounds of the
// last ten seconds. Each bound is loosened by the maximum drift since then. If both come from one round trip,
// this is the sample with the lowest round trip (RFC 5905, section 10). Not thread-safe.
class ClockOffset {
 public:
  // Maximum relative drift of two clocks. RFC 5905 assumes 15 ppm for a disciplined clock; cheap quartz
  // reaches 200 ppm.
  static constexpr double kMaxDrift = 200e-6;
  static constexpr int64_t kWindow_ns = 10'000'000'000;

  void add(const ClockSample& sample);

  struct Estimate {
    int64_t offset_ns = 0;       // server's clock minus the client's, now
    int64_t uncertainty_ns = 0;  // error bound while the drift is at most kMaxDrift
  };
  std::optional<Estimate> at(int64_t client_ns) const;

 private:
  // The tightest bound first, then those that become the tightest once earlier ones leave the window. All
  // bounds loosen alike, so a bound that is looser than a younger one is dropped.
  struct Bound {
    int64_t client_ns = 0;  // time of the sample
    int64_t value_ns = 0;   // the offset for the upper bound, its negative for the lower
  };
  using Bounds = std::deque<Bound>;
  static void tighten(Bounds& bounds, const Bound& bound);
  static int64_t loosened(const Bound& bound, int64_t client_ns);

  Bounds upper_, lower_;
};

}  // namespace livegs
