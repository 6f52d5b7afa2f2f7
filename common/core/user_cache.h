// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"

namespace livegs {

// $XDG_CACHE_HOME/livegs, else $HOME/.cache/livegs. NotFound when neither is set. It may not exist yet.
Result<std::filesystem::path> user_cache_folder();

}  // namespace livegs
