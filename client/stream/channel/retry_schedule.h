// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace livegs {

// When a client that lost its server opens the next connection: every 150 ms at first, so that a network that
// heals shows pictures again within 300 ms; every 400 ms after a minute, so that a server that comes back
// does within 500. Each pause is up to a fifth shorter, by `random`, so that the clients of one server do not
// come in step.
inline constexpr int64_t kRetryPause_ns = 150'000'000;
inline constexpr int64_t kLongRetryPause_ns = 400'000'000;
inline constexpr int64_t kLongRetryAfter_ns = 60'000'000'000;
// A connection that is not there after so long is given up: four round trips of a quarter of a second.
inline constexpr int64_t kConnectTimeout_ns = 1'000'000'000;

constexpr int64_t retry_pause_ns(int64_t outage_ns, uint32_t random) {
  const int64_t pause_ns = outage_ns < kLongRetryAfter_ns ? kRetryPause_ns : kLongRetryPause_ns;
  return pause_ns - pause_ns / 5 * (random % 1024) / 1023;
}

}  // namespace livegs
