// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gaussian/asset_frame.h"
#include "gaussian/gaussian_asset.h"

namespace livegs {

// A file as read. The readers are in asset_file.h.
enum class AssetFormat { Ply, CompressedPly, Spz, Sog, Splat, Gltf };

// Upper bound of deflate's compression ratio (1032:1 according to zlib). Limits the decoded size for every
// compressed format.
inline constexpr uint64_t kMaxCompressionRatio = 1032;

struct AssetFile {
  GaussianAsset asset;
  AssetFormat format = AssetFormat::Ply;
  int format_version = 0;          // spz 1 to 4, sog 1 or 2; 0 if the format has no version
  bool y_up_in_file = false;       // spz, glTF: stored with x right, y up, z back, and rotated by the reader
  AssetFrame frame;                // axes, unit and place that the file states
  std::vector<std::string> notes;  // changes made while reading, one per line
};

}  // namespace livegs
