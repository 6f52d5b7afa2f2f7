// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace livegs {

// Pause before the next connection attempt after a connection loss. 150 ms at first, so that pictures resume
// within 300 ms of a network recovery. 400 ms after a one-minute outage, so that the client reaches a
// restarted server within 500 ms. `random` shortens each pause by up to a fifth, which spreads the attempts
// of several clients.
inline constexpr int64_t kRetryPause_ns = 150'000'000;
inline constexpr int64_t kLongRetryPause_ns = 400'000'000;
inline constexpr int64_t kLongRetryAfter_ns = 60'000'000'000;
// An attempt that is not connected after this time is abandoned: four round trips of 250 ms.
inline constexpr int64_t kConnectTimeout_ns = 1'000'000'000;

constexpr int64_t retry_pause_ns(int64_t outage_ns, uint32_t random) {
  const int64_t pause_ns = outage_ns < kLongRetryAfter_ns ? kRetryPause_ns : kLongRetryPause_ns;
  return pause_ns - pause_ns / 5 * (random % 1024) / 1023;
}

}  // namespace livegs
