// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/scene_object.h"

#include "scene/build/elastic_report.h"

namespace livegs {

std::vector<std::string> SceneObject::all_warnings() const {
  std::vector<std::string> all = warnings;
  if (!mass_ratio_warning.empty()) all.push_back(mass_ratio_warning);
  if (elastic) {
    for (std::string& clipped : accuracy_warnings(*elastic)) all.push_back(std::move(clipped));
  }
  return all;
}

}  // namespace livegs
