// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "core/result.h"
#include "viewer/output/player.h"

namespace livegs {

// Writes first.png.
Result<void> write_first_picture(const Image& picture, const std::filesystem::path& folder);
// Writes last.png and last_frame.bin of the played pictures, if any.
Result<void> write_last_picture(const Player& player, const std::filesystem::path& folder);

}  // namespace livegs
