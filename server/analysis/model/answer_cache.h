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

// Answers that passed the gate, by the hash of everything that was asked: the same question is not asked
// twice. They are kept for ever, failures for ten minutes, in `folder` if there is one, so that a program
// that is run again does not pay for the same refusal. The answer is kept as it came, with its transcript
// unless that is longer than a megabyte, and judged again. Any thread.
class AnswerCache {
 public:
  static constexpr int64_t kFailureLifetime_ns = 600'000'000'000;

  // `clock_ns`: since 1970, as files outlive a boot; empty: the system's.
  explicit AnswerCache(std::filesystem::path folder = {}, std::function<int64_t()> clock_ns = {});

  std::optional<RawAnswer> answer(const std::string& key) const;
  std::optional<std::string> failure(const std::string& key) const;  // its message
  void keep(const std::string& key,
            const RawAnswer& answer);  // a folder that cannot be written is not an error
  void keep_failure(const std::string& key, const std::string& message);

 private:
  std::filesystem::path folder_;
  std::function<int64_t()> clock_ns_;
  mutable std::mutex mutex_;  // guards what follows
  mutable std::map<std::string, RawAnswer> answers_;
  mutable std::map<std::string, std::pair<int64_t, std::string>> failures_;  // until when
};

}  // namespace livegs
