// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace livegs::sample {

// Solid texture of wood: growth rings about the x axis of `grain_m`. Long grain, cathedrals and end grain
// follow from the orientation of the surface.
struct WoodTone {
  Eigen::Vector3d early, late;  // early and late wood, linear light
  double ring_m = 0.006;
  double detail = 1.0;  // strength of fibres and pores, which kernels wider than 2 mm cannot resolve
};

Eigen::Vector3d wood_albedo(const Eigen::Vector3d& grain_m, const WoodTone& tone, uint64_t seed);

}  // namespace livegs::sample
