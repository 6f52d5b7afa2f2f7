// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "core/result.h"

namespace livegs {

// Lifetime of a one-time code, and wrong tries after which it is invalid. A code has 8 of 32 letters and
// digits (40 bits): five tries guess it with a probability of 5e-12.
inline constexpr int64_t kOneTimeCodeLifetime_ns = 600'000'000'000;
inline constexpr int kMaxCodeTries = 5;

// The one-time code that a user transfers from the server to a browser, by link, QR code or keyboard. At most
// one is valid at a time. Any thread.
class OneTimeCodes {
 public:
  using Clock = std::function<int64_t()>;  // ns, monotonic
  explicit OneTimeCodes(Clock clock) : clock_(std::move(clock)) {}

  // A new code; an earlier one is no longer valid. Internal if the system has no random numbers.
  Result<std::string> create();
  // Checks a code. A valid code is used up. Case, spaces and hyphens are ignored. PermissionDenied otherwise;
  // the message has the remedy.
  Result<void> use(std::string_view code);

 private:
  const Clock clock_;
  std::mutex mutex_;  // guards everything below
  std::string code_;  // empty: none
  int64_t created_ns_ = 0;
  int tries_ = 0;
};

}  // namespace livegs
