// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"

namespace livegs {

// A segmented room as files: one asset for each thing, the room without them, a scene and a page.
struct SegmentedThing {
  std::string name;  // also of its files
  GaussianAsset asset;
  RoomPart part;
  bool unfilled = false;                           // the room behind it is not filled
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // of its box, along the axes of the asset and in its unit
};
struct SegmentedRoom {
  GaussianAsset room;  // without the things, filled behind them
  GaussianAsset original;
  std::vector<SegmentedThing> things;
  RoomParts parts;
  Eigen::Vector3d up;
  std::string up_axis;  // as in a scene file: "-y"
  double scale = 1.0;   // metres per unit of the asset
};

// The folder in the output folder in which the files are written first. A run that was killed leaves it.
inline constexpr const char* kUnfinishedFolder = ".part";

// Writes NAME.ply for each thing, room.ply, room.scene.json, labels.u16 and README.md with pictures. Files of
// the same names are replaced. After an error, nothing is written.
Result<void> write_segmented_room(const std::filesystem::path& folder, SegmentedRoom room);

}  // namespace livegs
