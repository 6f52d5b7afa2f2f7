// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "fit/fit_scene.h"
#include "fit/motion/surface_view.h"

namespace livegs {

// The scene of a request, simulated to the time of the first frame, and its visible surface points.
struct FirstFrame {
  v1::Scene file;  // every object has its name; the bodies of fitted objects are fixed
  std::vector<FitParameter> parameters;
  std::vector<std::string> objects;                // names of the fitted objects
  std::map<std::string, std::string> mass_source;  // by object
  SurfaceView view;
};
Result<FirstFrame> first_frame(const FitRequest& request, double time_s, std::shared_ptr<BuildCache> cache,
                               const FitProgress& progress);

}  // namespace livegs
