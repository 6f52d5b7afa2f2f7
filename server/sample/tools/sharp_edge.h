// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <functional>

#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// A painted edge drawn by kernels frays, because centres lie at random distances from it. Moves every sample
// that is nearer than `margin_m` to the edge (the zero line of `distance_m`, metres, slope near one) along
// the surface until it is that far, on its own side: the kernels then line up along the edge. Samples for
// which `distance_m` is not finite are left alone.
void line_up_along_edge(const std::function<double(const SurfaceSample&)>& distance_m, double margin_m,
                        SurfaceSamples& samples);

}  // namespace livegs::sample
