// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>

namespace livegs {

// A number that no other call has returned, above 0. Any thread. Compare for equality only: the order of the
// numbers depends on the threads.
inline uint64_t new_revision() {
  static std::atomic<uint64_t> last{0};
  return ++last;
}

}  // namespace livegs
