// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/pose.h"
#include "core/result.h"
#include "gaussian/gaussian_asset.h"

namespace livegs {

// An asset as it stands in a scene: metres, +Y up.
struct PlacedAsset {
  std::shared_ptr<const GaussianAsset> asset;
  Similarity object_from_asset;
  bool scale_known = false;                    // told by the scene or by the format, rather than guessed
  std::string scale_reason;                    // one sentence
  std::vector<Eigen::Vector3d> body_points_m;  // the kernels that make up the body, object frame
};

// Reads `path`, turns `up` ("-y" when empty) to +Y and scales to metres. Without `scale`: an .spz is metric;
// an asset whose size fits what its name usually measures is taken as metric; otherwise the name's usual size
// is used, and for a name that says nothing a longest side of kDefaultSize_m when the asset's own is not that
// of a thing in a room.
inline constexpr double kDefaultSize_m = 0.4;
Result<PlacedAsset> place_asset(const std::filesystem::path& path, std::string_view name,
                                std::optional<double> scale, std::string_view up, std::string_view field);

}  // namespace livegs
