// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <thread>

namespace livegs {

// Timeout for conditions that normally hold at once. Long enough for a loaded machine with a sanitizer.
inline constexpr std::chrono::seconds kPatience{60};

// Polls until the condition holds. Returns false after kPatience.
template <class Condition>
bool wait_until(const Condition& holds) {
  const auto give_up = std::chrono::steady_clock::now() + kPatience;
  while (!holds()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

}  // namespace livegs
