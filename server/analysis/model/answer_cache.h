// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>

#include "analysis/model/conversation.h"

namespace livegs {

// Cache of answers that passed the gate, keyed by the hash of the whole question; a question is not sent
// twice.
//
// Answers are kept without expiry and failures for ten minutes. With a `folder` both persist, so that a
// repeated program run does not pay for the same refusal again. An answer is stored as received and judged
// again on a hit; its transcript is dropped above one megabyte.
// Any thread.
class AnswerCache {
 public:
  static constexpr int64_t kFailureLifetime_ns = 600'000'000'000;

  // `clock_ns`: nanoseconds since 1970, because files persist across reboots; empty for the system clock.
  explicit AnswerCache(std::filesystem::path folder = {}, std::function<int64_t()> clock_ns = {});

  std::optional<RawAnswer> answer(const std::string& key) const;
  std::optional<std::string> failure(const std::string& key) const;  // the error message
  void keep(const std::string& key,
            const RawAnswer& answer);  // a folder that cannot be written is not an error
  void keep_failure(const std::string& key, const std::string& message);

 private:
  std::filesystem::path folder_;
  std::function<int64_t()> clock_ns_;
  mutable std::mutex mutex_;  // guards the members below
  mutable std::map<std::string, RawAnswer> answers_;
  mutable std::map<std::string, std::pair<int64_t, std::string>> failures_;  // expiry time and message
};

}  // namespace livegs
