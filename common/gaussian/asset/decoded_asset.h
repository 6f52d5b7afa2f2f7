// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"

namespace livegs {

// A file as it was read; asset_file.h has the readers.
enum class AssetFormat { Ply, CompressedPly, Spz, Sog, Splat };

// What deflate can reach at best (zlib's own figure is 1032:1); held against every compressed format.
inline constexpr uint64_t kMaxCompressionRatio = 1032;

struct AssetFile {
  GaussianAsset asset;
  AssetFormat format = AssetFormat::Ply;
  int format_version = 0;          // spz 1 to 4, sog 1 or 2; 0 where the format has none
  bool y_up_in_file = false;       // spz: stored as x right, y up, z back, and turned by the reader
  std::vector<std::string> notes;  // what was changed while reading, a line each
};

}  // namespace livegs
