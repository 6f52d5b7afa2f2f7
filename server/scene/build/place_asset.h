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
#include "gaussian/read_options.h"

namespace livegs {

// An asset in scene units: metres, +Y up.
struct PlacedAsset {
  std::shared_ptr<const GaussianAsset> asset;
  Similarity object_from_asset;
  bool scale_known = false;                    // given by the scene file or the format, not guessed
  bool scale_by_name = false;                  // guessed from the usual size of objects of this name
  bool up_known = false;                       // given by the scene file or the format
  std::string scale_reason;                    // one sentence
  std::vector<Eigen::Vector3d> body_points_m;  // positions of the kernels that form the body, object frame
};

// Reads `path`, rotates `up` (if empty: the axis that the file names, else "-y") to +Y and scales to metres.
// Without `scale`, the scale is chosen by the first rule that applies:
// - The unit that the file states.
// - The metre of the format (.spz, glTF), unless the file marks it as a guess, or the size is impossible
//   for the name: converters write these formats without knowing a unit.
// - An asset whose size fits its name is metric.
// - An asset with a known name gets the usual size of that object.
// - `assumed_scale`, if given.
// - Other assets are metric if the size is that of a household object, else kDefaultSize_m long.
inline constexpr double kDefaultSize_m = 0.4;
Result<PlacedAsset> place_asset(const std::filesystem::path& path, std::string_view name,
                                std::optional<double> scale, std::string_view up, std::string_view field,
                                std::optional<double> assumed_scale = std::nullopt,
                                const ReadOptions& read = {});

}  // namespace livegs
