// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "study/harness/setup.h"

// The bodies of the scenes: boxes filled with a regular grid of particles.

namespace livegs::study {

inline constexpr double kBarLength_m = 0.4, kBarWidth_m = 0.1;

// Voxel centres of the box, `spacing_m` apart. Precondition: every edge is a multiple of the spacing.
ParticleSet fill_box(const Eigen::Vector3d& min_m, const Eigen::Vector3d& max_m, double spacing_m);

// Undamped, at rest, without constraints.
ElasticBodyDescription describe_box(const Setup& setup, const Eigen::Vector3d& min_m,
                                    const Eigen::Vector3d& max_m);

// The bar of most scenes: kBarLength_m along x, kBarWidth_m square, centred at the origin.
ElasticBodyDescription describe_bar(const Setup& setup);

}  // namespace livegs::study
