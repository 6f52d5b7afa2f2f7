// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// How much of the light from a direction reaches a point past the object itself: the samples' area in a
// coarse grid of cubes, smoothed, marched along a ray. Soft by nature, which is what baked shading wants.
class OcclusionGrid {
 public:
  // `cells` along the longest side of the samples' box.
  explicit OcclusionGrid(const SurfaceSamples& samples, int cells = 72);

  // 0..1. Marching starts `clearance` cells away from the point along its normal, so that a surface does not
  // shade itself.
  double transmittance(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal,
                       const Eigen::Vector3d& direction, double clearance = 1.8) const;
  double cell_m() const { return cell_m_; }

 private:
  float density_at(const Eigen::Vector3f& cell_point) const;
  float& cell(int x, int y, int z) { return density_[(static_cast<size_t>(z) * ny_ + y) * nx_ + x]; }

  Eigen::Vector3d low_m_;
  double cell_m_ = 1.0;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<float> density_;  // of a crossing of one cell: optical depth
};

}  // namespace livegs::sample
