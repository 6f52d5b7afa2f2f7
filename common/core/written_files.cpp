// SPDX-License-Identifier: Apache-2.0
#include "core/written_files.h"

#include <algorithm>
#include <mutex>

namespace livegs {
namespace {

// Files of one folder with the same ending.
struct Group {
  std::filesystem::path folder, ending;
  std::vector<std::filesystem::path> files;
};

std::mutex mutex;           // guards the groups
std::vector<Group> groups;  // in the order of their first files

}  // namespace

void note_written(const std::filesystem::path& path) {
  std::lock_guard lock(mutex);
  auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& one) {
    return one.folder == path.parent_path() && one.ending == path.extension();
  });
  if (group == groups.end()) group = groups.insert(groups.end(), {path.parent_path(), path.extension(), {}});
  if (std::find(group->files.rbegin(), group->files.rend(), path) == group->files.rend())
    group->files.push_back(path);
}

std::vector<std::filesystem::path> written_files() {
  std::lock_guard lock(mutex);
  std::vector<std::filesystem::path> files;
  std::error_code ignored;
  for (const Group& group : groups) {
    for (const std::filesystem::path& file : group.files) {
      if (std::filesystem::exists(file, ignored)) files.push_back(file);
    }
  }
  return files;
}

std::string written_files_text() {
  std::lock_guard lock(mutex);
  std::string text;
  for (Group group : groups) {
    std::erase_if(group.files, [](const std::filesystem::path& file) {
      std::error_code ignored;
      return !std::filesystem::exists(file, ignored);
    });
    if (group.files.size() > kMaxNamedFiles) {
      text += "written: " + std::to_string(group.files.size()) + " files, " + group.files.front().string() +
              " to " + group.files.back().filename().string() + "\n";
      continue;
    }
    for (const std::filesystem::path& file : group.files) text += "written: " + file.string() + "\n";
  }
  return text;
}

}  // namespace livegs
