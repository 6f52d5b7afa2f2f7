// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "train/render/trained_view.h"

namespace livegs {

// A number of the test's own sequence, identical on every machine, low <= value < high.
double between(double low, double high, uint64_t stream, uint64_t index);

Camera test_camera(int width, int height);
// Kernels of all directions and shapes around the origin, with view-dependent colour. `max_opacity` < 0.99.
KernelParameters test_kernels(size_t count, double max_opacity);
// -1 to 1 for each number of the picture.
PicturePlanes random_weights(int width, int height);
// Without jumps of the picture: see RenderCuts.
TrainedViewOptions smooth_options();

}  // namespace livegs
