// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// Sharpens a painted edge, which would otherwise look frayed because kernel centres lie at random distances.
// Each sample within `margin_m` of the edge (the zero line of `distance_m`, metres, slope near one) is moved
// along the surface to that distance, on its own side. Samples with a non-finite `distance_m` are not moved.
void line_up_along_edge(const std::function<double(const SurfaceSample&)>& distance_m, double margin_m,
                        SurfaceSamples& samples);

}  // namespace livegs::sample
