// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"

namespace livegs {

// $XDG_CACHE_HOME/livegs, or $HOME/.cache/livegs. NotFound if neither is set. The folder may not exist yet.
Result<std::filesystem::path> user_cache_folder();

}  // namespace livegs
