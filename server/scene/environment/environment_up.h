// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include "livegs/v1/scene.pb.h"

namespace livegs {

// The up axis of a captured room: that of the scene file, else the one that the asset names, else empty (-y).
// Reads the head of the asset.
std::string environment_up(const v1::Environment& environment, const std::filesystem::path& folder);

}  // namespace livegs
