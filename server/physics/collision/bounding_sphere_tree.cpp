// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/bounding_sphere_tree.h"

#include <Eigen/Geometry>
#include <numeric>
#include <utility>

namespace livegs {

BoundingSphereTree::BoundingSphereTree(std::span<const Eigen::Vector3d> points_m) : order_(points_m.size()) {
  std::iota(order_.begin(), order_.end(), 0u);
  if (!order_.empty()) add_group(points_m, 0, static_cast<uint32_t>(order_.size()));
}

void BoundingSphereTree::add_group(std::span<const Eigen::Vector3d> points_m, uint32_t begin, uint32_t end) {
  Eigen::AlignedBox3d box;
  for (uint32_t i = begin; i < end; ++i) box.extend(points_m[order_[i]]);
  const Eigen::Vector3d centre = box.center();
  double squared = 0.0;
  for (uint32_t i = begin; i < end; ++i)
    squared = std::max(squared, (points_m[order_[i]] - centre).squaredNorm());
  const size_t own = groups_.size();
  // The margin keeps every point inside despite rounding.
  groups_.push_back({centre, (1.0 + 1e-9) * std::sqrt(squared), begin, end, 0});
  if (end - begin > 6) {  // larger leaves: fewer nodes, more points tested
    Eigen::Index axis;
    box.sizes().maxCoeff(&axis);
    const uint32_t middle = begin + (end - begin) / 2;
    std::ranges::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, {},
                             [&](uint32_t i) { return std::pair(points_m[i][axis], i); });
    add_group(points_m, begin, middle);
    add_group(points_m, middle, end);
  }
  groups_[own].after = static_cast<uint32_t>(groups_.size());
}

}  // namespace livegs
