// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <functional>
#include <vector>

namespace livegs::bench {

struct Times {
  double median_ms = 0.0;
  double p99_ms = 0.0;
  double cpu_ms = 0.0;  // median processor time of all threads; hardly depends on other load
};

// Wall and processor time of `work` over `repeats` runs, after `warm_up` untimed runs.
inline Times time_of(int warm_up, int repeats, const std::function<void()>& work) {
  for (int i = 0; i < warm_up; ++i) work();
  std::vector<double> times_ms, cpu_times_ms;
  for (int i = 0; i < repeats; ++i) {
    const std::clock_t cpu_start = std::clock();
    const auto start = std::chrono::steady_clock::now();
    work();
    times_ms.push_back(
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    cpu_times_ms.push_back(1e3 * static_cast<double>(std::clock() - cpu_start) / CLOCKS_PER_SEC);
  }
  std::sort(times_ms.begin(), times_ms.end());
  std::sort(cpu_times_ms.begin(), cpu_times_ms.end());
  const size_t last = times_ms.size() - 1;
  return {times_ms[last / 2], times_ms[static_cast<size_t>(0.99 * static_cast<double>(last) + 0.5)],
          cpu_times_ms[last / 2]};
}

}  // namespace livegs::bench
