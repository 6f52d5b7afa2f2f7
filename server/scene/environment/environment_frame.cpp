// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment/environment_frame.h"

#include <utility>

#include "gaussian/asset_file.h"

namespace livegs {

AssetFrame environment_frame(const v1::Environment& environment, const std::filesystem::path& folder) {
  const bool all_given = !environment.up().empty() && environment.has_scale();
  const bool named = !all_given && !environment.asset().empty();
  return environment_frame(environment, named ? named_frame(folder / environment.asset()) : AssetFrame{});
}

AssetFrame environment_frame(const v1::Environment& environment, AssetFrame of_asset) {
  AssetFrame frame = std::move(of_asset);
  if (!environment.up().empty()) frame.up_axis = environment.up();
  if (environment.has_scale()) frame.metres_per_unit = environment.scale();
  if (!(frame.metres_per_unit > 0)) frame.metres_per_unit = 1;
  return frame;
}

}  // namespace livegs
