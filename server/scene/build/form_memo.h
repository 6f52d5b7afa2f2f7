// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace livegs {

// What depends on the form of an object alone, such as its contact shape, shared by objects of equal form: a
// scene of many equal boxes computes it once. Any thread.
class FormMemo {
 public:
  // The value of `key`, from make() if there is none. Threads that need it at once may each make it, with
  // the same result. A key stands for one type.
  template <typename Value, typename Make>
  std::shared_ptr<const Value> value(const std::string& key, const Make& make) {
    if (auto known = find(key)) return std::static_pointer_cast<const Value>(known);
    auto made = std::make_shared<const Value>(make());
    keep(key, made);
    return made;
  }

 private:
  // Values; the oldest go first. Larger: more memory. Smaller: scenes of more forms than this build equal
  // forms again.
  static constexpr size_t kMaxValues = 256;

  std::shared_ptr<const void> find(const std::string& key) {
    std::lock_guard lock(mutex_);
    const auto found = values_.find(key);
    return found == values_.end() ? nullptr : found->second;
  }
  void keep(const std::string& key, std::shared_ptr<const void> value) {
    std::lock_guard lock(mutex_);
    if (!values_.emplace(key, std::move(value)).second) return;
    by_age_.push_back(key);
    if (by_age_.size() <= kMaxValues) return;
    values_.erase(by_age_.front());
    by_age_.pop_front();
  }

  std::mutex mutex_;  // guards the rest
  std::map<std::string, std::shared_ptr<const void>> values_;
  std::list<std::string> by_age_;
};

}  // namespace livegs
