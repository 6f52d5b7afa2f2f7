// SPDX-License-Identifier: Apache-2.0
#include "core/user_cache.h"

#include <cstdlib>

namespace livegs {

Result<std::filesystem::path> user_cache_folder() {
  if (const char* cache = std::getenv("XDG_CACHE_HOME"); cache != nullptr && *cache == '/') {
    return std::filesystem::path(cache) / "livegs";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return std::filesystem::path(home) / ".cache" / "livegs";
  }
  return not_found("user cache: neither XDG_CACHE_HOME nor HOME is set; set one of them");
}

}  // namespace livegs
