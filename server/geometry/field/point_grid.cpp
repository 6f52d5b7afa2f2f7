// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/field/point_grid.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/assert.h"

namespace livegs {

PointGrid::PointGrid(const Eigen::AlignedBox3d& bounds_m, double cell_m) {
  LIVEGS_ASSERT(cell_m > 0.0 && !bounds_m.isEmpty());
  cells_.origin_m = bounds_m.min();
  cells_.cell_m = affordable_cell_m(cell_m, bounds_m.sizes());
  cells_.counts = (bounds_m.sizes() / cells_.cell_m).array().floor().cast<int>() + 1;
  last_in_cell_.assign(cells_.size(), -1);
}

Eigen::Vector3i PointGrid::cell_of(const Eigen::Vector3d& point_m) const {
  const Eigen::Array3d place = ((point_m - cells_.origin_m) / cells_.cell_m).array().floor();
  return place.max(0.0).min((cells_.counts.array() - 1).cast<double>()).cast<int>();
}

void PointGrid::insert(const Eigen::Vector3d& point_m) {
  const Eigen::Vector3i cell = cell_of(point_m);
  int32_t& last = last_in_cell_[cells_.index(cell.x(), cell.y(), cell.z())];
  one_before_.push_back(last);
  last = static_cast<int32_t>(points_m_.size());
  points_m_.push_back(point_m);
}

bool PointGrid::has_neighbour_within(const Eigen::Vector3d& point_m, double radius_m) const {
  const Eigen::Vector3i low = cell_of(point_m.array() - radius_m), high = cell_of(point_m.array() + radius_m);
  for (int k = low.z(); k <= high.z(); ++k) {
    for (int j = low.y(); j <= high.y(); ++j) {
      for (int i = low.x(); i <= high.x(); ++i) {
        for (int32_t p = last_in_cell_[cells_.index(i, j, k)]; p >= 0; p = one_before_[p]) {
          if ((points_m_[p] - point_m).squaredNorm() < radius_m * radius_m) return true;
        }
      }
    }
  }
  return false;
}

uint32_t PointGrid::nearest(const Eigen::Vector3d& point_m) const {
  LIVEGS_ASSERT(!points_m_.empty());
  const Eigen::Vector3i middle = cell_of(point_m);
  // For a query outside the bounds, each ring of cells is at least as far as from the nearest point inside.
  const int last_ring = cells_.counts.maxCoeff();
  double best2 = std::numeric_limits<double>::max();
  int32_t best = -1;
  for (int ring = 0; ring <= last_ring; ++ring) {
    const double clear_m = (ring - 1) * cells_.cell_m;  // minimum distance of the points in this ring
    if (best >= 0 && clear_m > 0.0 && clear_m * clear_m > best2) break;
    for (int k = std::max(middle.z() - ring, 0); k <= std::min(middle.z() + ring, cells_.counts.z() - 1);
         ++k) {
      for (int j = std::max(middle.y() - ring, 0); j <= std::min(middle.y() + ring, cells_.counts.y() - 1);
           ++j) {
        const bool whole_row = std::abs(k - middle.z()) == ring || std::abs(j - middle.y()) == ring;
        for (int i = middle.x() - ring; i <= middle.x() + ring; i += whole_row ? 1 : std::max(2 * ring, 1)) {
          if (i < 0 || i >= cells_.counts.x()) continue;
          for (int32_t p = last_in_cell_[cells_.index(i, j, k)]; p >= 0; p = one_before_[p]) {
            const double distance2 = (points_m_[p] - point_m).squaredNorm();
            if (distance2 < best2 || (distance2 == best2 && p < best)) {
              best2 = distance2;
              best = p;
            }
          }
        }
      }
    }
  }
  return static_cast<uint32_t>(best);
}

}  // namespace livegs
