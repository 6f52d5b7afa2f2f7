// SPDX-License-Identifier: GPL-3.0-or-later
#include "sample/tools/occlusion_grid.h"

#include <algorithm>
#include <cmath>

namespace livegs::sample {

OcclusionGrid::OcclusionGrid(const SurfaceSamples& samples, int cells) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const SurfaceSample& s : samples) {
    low = low.cwiseMin(s.position_m);
    high = high.cwiseMax(s.position_m);
  }
  cell_m_ = (high - low).maxCoeff() / cells;
  low_m_ = low - Eigen::Vector3d::Constant(2.5 * cell_m_);
  const Eigen::Vector3d span = (high - low) / cell_m_;
  nx_ = static_cast<int>(span.x()) + 6;
  ny_ = static_cast<int>(span.y()) + 6;
  nz_ = static_cast<int>(span.z()) + 6;
  density_.assign(static_cast<size_t>(nx_) * ny_ * nz_, 0.0f);
  for (const SurfaceSample& s : samples) {
    // A saturated sheet across a cell has an optical depth of 3, distributed to the eight nearest cells.
    const double depth = 3.0 * s.spacing_m * s.spacing_m * s.stretch / 0.65 / (cell_m_ * cell_m_);
    const Eigen::Vector3d place = (s.position_m - low_m_) / cell_m_;
    const Eigen::Vector3d base = (place - Eigen::Vector3d::Constant(0.5)).array().floor();
    const Eigen::Vector3d w = place - Eigen::Vector3d::Constant(0.5) - base;
    for (int corner = 0; corner < 8; ++corner) {
      const int dx = corner & 1, dy = (corner >> 1) & 1, dz = corner >> 2;
      cell(static_cast<int>(base.x()) + dx, static_cast<int>(base.y()) + dy,
           static_cast<int>(base.z()) + dz) +=
          static_cast<float>(depth * (dx ? w.x() : 1 - w.x()) * (dy ? w.y() : 1 - w.y()) *
                             (dz ? w.z() : 1 - w.z()));
    }
  }
}

float OcclusionGrid::density_at(const Eigen::Vector3f& p) const {
  const int x = static_cast<int>(p.x()), y = static_cast<int>(p.y()), z = static_cast<int>(p.z());
  const float wx = p.x() - static_cast<float>(x), wy = p.y() - static_cast<float>(y),
              wz = p.z() - static_cast<float>(z);
  const float* c = &density_[(static_cast<size_t>(z) * ny_ + y) * nx_ + x];
  const size_t row = static_cast<size_t>(nx_), slab = static_cast<size_t>(nx_) * ny_;
  const auto line = [&](const float* q) { return q[0] + (q[1] - q[0]) * wx; };
  const float bottom = line(c) + (line(c + row) - line(c)) * wy;
  const float top = line(c + slab) + (line(c + slab + row) - line(c + slab)) * wy;
  return bottom + (top - bottom) * wz;
}

double OcclusionGrid::transmittance(const Eigen::Vector3d& point_m, const Eigen::Vector3d& normal,
                                    const Eigen::Vector3d& direction, double clearance) const {
  const Eigen::Vector3f toward = direction.cast<float>();
  Eigen::Vector3f p =
      ((point_m - low_m_) / cell_m_ - Eigen::Vector3d::Constant(0.5) + clearance * normal).cast<float>();
  const Eigen::Vector3f end(static_cast<float>(nx_ - 1), static_cast<float>(ny_ - 1),
                            static_cast<float>(nz_ - 1));
  const auto inside = [&] {
    return p.x() >= 0 && p.y() >= 0 && p.z() >= 0 && p.x() < end.x() && p.y() < end.y() && p.z() < end.z();
  };
  // Steps grow with the width of the cone of light of a direction; distant steps use the nearest cell. Above
  // a depth of 4 no light is left.
  float depth = 0.0f, step = 0.9f;
  p += 0.5f * toward;
  for (int near = 0; near < 4 && inside() && depth < 4.0f; ++near, p += step * toward, step *= 1.15f)
    depth += step * density_at(p);
  p += Eigen::Vector3f::Constant(0.5f);
  for (; inside() && depth < 4.0f; p += step * toward, step *= 1.1f) {
    const size_t row = static_cast<size_t>(p.z()) * ny_ + static_cast<size_t>(p.y());
    depth += step * density_[row * nx_ + static_cast<size_t>(p.x())];
  }
  return std::exp(-depth);
}

}  // namespace livegs::sample
