// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs::sample {

// Solid wood: growth rings about the x axis of `grain_m`, cut wherever the surface happens to run, so that
// long grain, cathedrals and end grain come out by themselves.
struct WoodTone {
  Eigen::Vector3d early, late;  // spring and summer wood, linear light
  double ring_m = 0.006;
  double detail = 1.0;  // strength of fibres and pores, which kernels wider than 2 mm cannot carry
};

Eigen::Vector3d wood_albedo(const Eigen::Vector3d& grain_m, const WoodTone& tone, uint64_t seed);

}  // namespace livegs::sample
