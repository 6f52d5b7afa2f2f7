// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/environment/environment_up.h"

#include "gaussian/asset_file.h"

namespace livegs {

std::string environment_up(const v1::Environment& environment, const std::filesystem::path& folder) {
  if (!environment.up().empty() || environment.asset().empty()) return environment.up();
  return named_up_axis(folder / environment.asset());
}

}  // namespace livegs
