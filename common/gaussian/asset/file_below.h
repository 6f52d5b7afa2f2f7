// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>

namespace livegs {

// Whether a path that a file names is a file below its folder, on any system, and can be shown in a line.
inline bool is_file_below(const std::string& path) {
  const std::filesystem::path parts(path);
  return !path.empty() && !parts.is_absolute() && path.find_first_of("\\:") == path.npos &&
         std::none_of(path.begin(), path.end(), [](unsigned char c) { return c < 32 || c == 127; }) &&
         std::find(parts.begin(), parts.end(), "..") == parts.end();
}

}  // namespace livegs
