// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/sharp_edge.h"

#include <cmath>

namespace livegs::sample {

void line_up_along_edge(const std::function<double(const SurfaceSample&)>& distance_m, double margin_m,
                        SurfaceSamples& samples) {
  constexpr double kStep_m = 1e-5;
  for (SurfaceSample& sample : samples) {
    const double from_m = distance_m(sample);
    if (!(std::abs(from_m) < margin_m)) continue;
    Eigen::Vector3d slope;
    for (int axis = 0; axis < 3; ++axis) {
      SurfaceSample shifted = sample;
      shifted.position_m[axis] += kStep_m;
      slope[axis] = (distance_m(shifted) - from_m) / kStep_m;
    }
    slope -= sample.normal * sample.normal.dot(slope);
    const double steepness = slope.norm();
    // Skipped where the distance hardly changes along the surface.
    if (!(steepness > 0.3)) continue;
    const double to_m = from_m < 0 ? -margin_m : margin_m;
    sample.position_m += slope * ((to_m - from_m) / (steepness * steepness));
  }
}

}  // namespace livegs::sample
