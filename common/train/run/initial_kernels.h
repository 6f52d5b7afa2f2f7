// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "capture/capture.h"
#include "train/kernel_parameters.h"

namespace livegs {

// One round kernel for each point of the capture, with the mean distance of its three nearest neighbours as
// standard deviation and an opacity of a half. More than `max_count` points are thinned evenly. A capture
// with fewer than kMinPoints gets kRandomPoints grey ones at random in the views of its cameras.
inline constexpr size_t kMinPoints = 100, kRandomPoints = 5000;
KernelParameters initial_kernels(const Capture& capture, double extent, size_t max_count, uint64_t seed);

// Root mean square distance to the three nearest other points; of fewer if there are fewer.
std::vector<float> neighbour_distances(const std::vector<Eigen::Vector3f>& points);

}  // namespace livegs
