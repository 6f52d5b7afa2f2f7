// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sample/tools/surface_sample.h"

namespace livegs::sample {

// Fraction of the light from a direction that reaches a point past the object itself. The samples' area is
// stored in a coarse grid, smoothed, and ray-marched. The result is soft, as required for baked shading.
class OcclusionGrid {
 public:
  // `cells`: number of cells along the longest side of the samples' bounding box.
  explicit OcclusionGrid(const SurfaceSamples& samples, int cells = 72);

  // Returns a value in 0..1. Marching starts `clearance` cells from the point along its normal, which avoids
  // self-shadowing.
  double transmittance(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal,
                       const Eigen::Vector3d& direction, double clearance = 1.8) const;
  double cell_m() const { return cell_m_; }

 private:
  float density_at(const Eigen::Vector3f& cell_point) const;
  float& cell(int x, int y, int z) { return density_[(static_cast<size_t>(z) * ny_ + y) * nx_ + x]; }

  Eigen::Vector3d low_m_;
  double cell_m_ = 1.0;
  int nx_ = 0, ny_ = 0, nz_ = 0;
  std::vector<float> density_;  // optical depth of a path across one cell
};

}  // namespace livegs::sample
