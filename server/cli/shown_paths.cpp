// SPDX-License-Identifier: GPL-3.0-or-later
#include "cli/shown_paths.h"

#include <mutex>
#include <utility>
#include <vector>

namespace livegs {
namespace {

std::mutex mutex;                                           // guards shown_as
std::vector<std::pair<std::string, std::string>> shown_as;  // path and name

}  // namespace

void show_path_as(const std::filesystem::path& path, const std::string& shown) {
  std::lock_guard lock(mutex);
  shown_as.emplace_back(path.string(), shown);
}

std::string with_shown_paths(std::string text) {
  std::lock_guard lock(mutex);
  for (const auto& [path, shown] : shown_as) {
    for (size_t at = 0; (at = text.find(path, at)) != std::string::npos; at += shown.size())
      text.replace(at, path.size(), shown);
  }
  return text;
}

}  // namespace livegs
