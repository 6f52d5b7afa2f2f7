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
  size_t count = 16;  // pieces wanted, 1 to kMaxSeeds
  uint64_t seed = 1;
  // Where blows fall, in the mesh's frame. Seeds are denser near them.
  std::span<const Eigen::Vector3d> impacts_m;
  // How much denser at an impact than far from it, at least 1, and how far that reaches, in parts of the
  // diagonal of the bounding box: density 1 + (ratio - 1) exp(-(distance / reach)²).
  double impact_density = 8.0;
  double impact_reach = 0.15;
};
inline constexpr size_t kMaxSeeds = 64;

// Points inside a closed mesh, spread by volume: of many random points in the body, each next seed is the one
// farthest from those chosen, in units of the spacing wanted there (best-candidate sampling, Mitchell 1991,
// with a weighted distance). Deterministic: the same options give the same bits. Fails on values out of range
// and on a mesh that encloses no volume.
Result<std::vector<Eigen::Vector3d>> fracture_seeds(const TriangleMesh& mesh, const SeedOptions& options);

}  // namespace livegs
