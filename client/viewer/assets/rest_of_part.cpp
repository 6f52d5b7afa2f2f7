// SPDX-License-Identifier: Apache-2.0
#include "viewer/assets/rest_of_part.h"

namespace livegs {

RestBody rest_of_part(const RestBody& rest, std::span<const uint32_t> indices) {
  RestBody part = rest;
  part.kernel_runs.clear();
  size_t run = 0;
  uint64_t end = rest.kernel_runs.empty() ? 0 : rest.kernel_runs[0].count;
  for (const uint32_t index : indices) {
    while (run < rest.kernel_runs.size() && index >= end) {
      if (++run < rest.kernel_runs.size()) end += rest.kernel_runs[run].count;
    }
    if (run == rest.kernel_runs.size()) break;  // also for an object that is not fractured
    const uint32_t body = rest.kernel_runs[run].body;
    if (part.kernel_runs.empty() || part.kernel_runs.back().body != body)
      part.kernel_runs.push_back({body, 0});
    ++part.kernel_runs.back().count;
  }
  return part;
}

}  // namespace livegs
