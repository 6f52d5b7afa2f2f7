// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/model/answer_cache.h"

#include <chrono>

#include "analysis/model/raw_answer_json.h"
#include "core/file.h"
#include "core/log.h"

namespace livegs {
namespace {

constexpr size_t kMaxCachedBytes = 1 << 20;

int64_t since_1970_ns() {
  using std::chrono::duration_cast, std::chrono::nanoseconds, std::chrono::system_clock;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

std::filesystem::path failure_path(const std::filesystem::path& folder, const std::string& key) {
  return folder / (key + ".failed.json");
}

std::optional<std::pair<int64_t, std::string>> read_failure(const std::filesystem::path& path) {
  const auto text = read_text_file(path, kMaxCachedBytes);
  if (!text) return std::nullopt;
  const Json json = Json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("until_ns") || !json["until_ns"].is_number_integer() ||
      !json.contains("message") || !json["message"].is_string()) {
    return std::nullopt;
  }
  return std::pair(json["until_ns"].get<int64_t>(), json["message"].get<std::string>());
}

}  // namespace

AnswerCache::AnswerCache(std::filesystem::path folder, std::function<int64_t()> clock_ns)
    : folder_(std::move(folder)), clock_ns_(clock_ns ? std::move(clock_ns) : since_1970_ns) {}

std::optional<RawAnswer> AnswerCache::answer(const std::string& key) const {
  std::lock_guard lock(mutex_);
  if (const auto found = answers_.find(key); found != answers_.end()) return found->second;
  if (folder_.empty()) return std::nullopt;
  const auto text = read_text_file(folder_ / (key + ".json"), kMaxCachedBytes);
  if (!text) return std::nullopt;
  auto answer = read_raw_answer(Json::parse(*text, nullptr, false));
  if (answer) answers_[key] = *answer;
  return answer;
}

std::optional<std::string> AnswerCache::failure(const std::string& key) const {
  std::lock_guard lock(mutex_);
  auto found = failures_.find(key);
  if (found == failures_.end()) {
    auto failed = folder_.empty() ? std::nullopt : read_failure(failure_path(folder_, key));
    if (!failed) return std::nullopt;
    found = failures_.emplace(key, std::move(*failed)).first;
  }
  // Bounds the remaining time in case the clock was set back.
  const int64_t left_ns = found->second.first - clock_ns_();
  if (left_ns > 0 && left_ns <= kFailureLifetime_ns) return found->second.second;
  failures_.erase(found);
  std::error_code ignored;
  if (!folder_.empty()) std::filesystem::remove(failure_path(folder_, key), ignored);
  return std::nullopt;
}

void AnswerCache::keep(const std::string& key, const RawAnswer& answer) {
  std::lock_guard lock(mutex_);
  answers_[key] = answer;
  failures_.erase(key);
  if (folder_.empty()) return;
  std::error_code ignored;
  std::filesystem::remove(failure_path(folder_, key), ignored);
  std::filesystem::create_directories(folder_, ignored);
  const auto written_as = [](const RawAnswer& one) {
    return raw_answer_json(one).dump(1, ' ', false, Json::error_handler_t::replace);
  };
  std::string text = written_as(answer);
  if (text.size() > kMaxCachedBytes) {
    RawAnswer shorter = answer;
    shorter.transcript.clear();
    text = written_as(shorter);
  }
  if (auto written = write_file_atomically(folder_ / (key + ".json"), text); !written) {
    log_debug("analysis: answer not cached: %s", written.error().message.c_str());
  }
}

void AnswerCache::keep_failure(const std::string& key, const std::string& message) {
  std::lock_guard lock(mutex_);
  const int64_t until_ns = clock_ns_() + kFailureLifetime_ns;
  failures_[key] = {until_ns, message};
  if (folder_.empty()) return;
  std::error_code ignored;
  std::filesystem::create_directories(folder_, ignored);
  const std::string text =
      Json{{"until_ns", until_ns}, {"message", message}}.dump(1, ' ', false, Json::error_handler_t::replace);
  if (auto written = write_file_atomically(failure_path(folder_, key), text); !written) {
    log_debug("analysis: failure not cached: %s", written.error().message.c_str());
  }
}

}  // namespace livegs
