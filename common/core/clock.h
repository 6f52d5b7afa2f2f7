// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace livegs {

// Monotonic time in nanoseconds (CLOCK_MONOTONIC, the clock of OpenXR's timespec conversion). Never wall
// time.
int64_t now_ns();

// Processor time of the calling thread, in seconds.
double thread_cpu_s();

// Blocks the calling thread until `moment_ns` of that clock. Returns at once if the moment has passed.
void sleep_until_ns(int64_t moment_ns);

constexpr double seconds_from_ns(int64_t duration_ns) { return static_cast<double>(duration_ns) * 1e-9; }
constexpr double milliseconds_from_ns(int64_t duration_ns) { return static_cast<double>(duration_ns) * 1e-6; }

}  // namespace livegs
