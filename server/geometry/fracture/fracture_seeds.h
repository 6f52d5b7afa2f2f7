// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "core/result.h"
#include "geometry/triangle_mesh.h"

namespace livegs {

struct SeedOptions {
  size_t count = 16;  // number of seeds, 1 to kMaxSeeds
  uint64_t seed = 1;
  // Points of impact, in the mesh's frame. Seeds are denser near them.
  std::span<const Eigen::Vector3d> impacts_m;
  // Density ratio at an impact, at least 1, and its range relative to the diagonal of the bounding box:
  // density 1 + (ratio - 1) exp(-(distance / reach)²).
  double impact_density = 8.0;
  double impact_reach = 0.15;
};
inline constexpr size_t kMaxSeeds = 64;

// Returns points inside a closed mesh, distributed by volume with weighted best-candidate sampling (Mitchell
// 1991). Each seed is the candidate farthest from the earlier seeds, in units of the local spacing.
// Deterministic: equal options give the same bits. Fails on values out of range and on a mesh that encloses
// no volume.
Result<std::vector<Eigen::Vector3d>> fracture_seeds(const TriangleMesh& mesh, const SeedOptions& options);

}  // namespace livegs
