// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"
#include "viewer/output/player.h"

namespace livegs {

// first.png, last.png and last_frame.bin of what was played, if there was anything.
Result<void> write_pictures(const Player& player, const std::filesystem::path& folder);

}  // namespace livegs
