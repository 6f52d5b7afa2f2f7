// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "gaussian/asset_frame.h"
#include "livegs/v1/scene.pb.h"

namespace livegs {

// Axis and unit of a captured room: those of the scene file, else those that the asset names, else -y (an
// empty axis) and metres. Reads the head of a .ply, and other assets whole. Any thread.
AssetFrame environment_frame(const v1::Environment& environment, const std::filesystem::path& folder);
// The same for an asset that was read.
AssetFrame environment_frame(const v1::Environment& environment, AssetFrame of_asset);

}  // namespace livegs
