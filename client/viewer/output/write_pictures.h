// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"
#include "viewer/output/player.h"

namespace livegs {

// Writes first.png, last.png and last_frame.bin of the played pictures, if any.
Result<void> write_pictures(const Player& player, const std::filesystem::path& folder);

}  // namespace livegs
