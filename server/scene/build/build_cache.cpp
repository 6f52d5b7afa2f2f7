// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/build/build_cache.h"

#include <algorithm>
#include <vector>

namespace livegs {

namespace fs = std::filesystem;

std::string BuildCache::stamp_of(const fs::path& path) {
  std::error_code error;
  std::string stamp;
  const auto add = [&](const fs::path& file) {
    stamp += file.string() + '|' + std::to_string(fs::file_size(file, error)) + '|' +
             std::to_string(fs::last_write_time(file, error).time_since_epoch().count()) + ';';
  };
  const fs::path folder = path.filename() == "meta.json" ? path.parent_path() : path;
  if (!fs::is_directory(folder, error)) {
    add(path);
    return stamp;
  }
  std::vector<fs::path> files;
  for (const auto& file : fs::directory_iterator(folder, error)) files.push_back(file.path());
  std::sort(files.begin(), files.end());
  for (const fs::path& file : files) add(file);
  return stamp;
}

std::shared_ptr<const void> BuildCache::found(const std::string& key) {
  std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (entry == entries_.end()) return nullptr;
  by_age_.splice(by_age_.begin(), by_age_, entry->second.age);
  return entry->second.value;
}

void BuildCache::keep(const std::string& key, std::shared_ptr<const void> value, size_t bytes) {
  std::lock_guard lock(mutex_);
  if (const auto known = entries_.find(key); known != entries_.end()) {
    bytes_ -= known->second.bytes;
    by_age_.erase(known->second.age);
    entries_.erase(known);
  }
  by_age_.push_front(key);
  entries_[key] = {std::move(value), bytes, by_age_.begin()};
  bytes_ += bytes;
  while (bytes_ > max_bytes_ && by_age_.size() > 1) {
    const auto oldest = entries_.find(by_age_.back());
    bytes_ -= oldest->second.bytes;
    entries_.erase(oldest);
    by_age_.pop_back();
  }
}

}  // namespace livegs
