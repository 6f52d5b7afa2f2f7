// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// Bounding sphere hierarchy over points, used to skip points far from a surface. Stores indices only.
// Immutable after construction; safe for concurrent queries.
class BoundingSphereTree {
 public:
  BoundingSphereTree() = default;
  explicit BoundingSphereTree(std::span<const Eigen::Vector3d> points_m);

  // Appends to `found` the indices, ascending, of all points that may be within `reach_m` of a surface
  // (conservative: some are farther). `clearance_m(p)`, in the frame of the points, is a lower bound of the
  // distance from p to the surface.
  template <class Clearance>
  void near(const Clearance& clearance_m, double reach_m, std::vector<uint32_t>& found) const {
    const auto first = static_cast<std::ptrdiff_t>(found.size());
    for (uint32_t i = 0; i < groups_.size();) {
      const Group& group = groups_[i];
      if (clearance_m(group.centre_m) - group.radius_m > reach_m) {
        i = group.after;
        continue;
      }
      if (group.after == i + 1)
        found.insert(found.end(), order_.begin() + group.begin, order_.begin() + group.end);
      ++i;
    }
    std::sort(found.begin() + first, found.end());
  }

 private:
  struct Group {
    Eigen::Vector3d centre_m;
    double radius_m;
    uint32_t begin, end;  // range in order_
    uint32_t after;       // index of the next group outside this one
  };
  void add_group(std::span<const Eigen::Vector3d> points_m, uint32_t begin, uint32_t end);

  std::vector<Group> groups_;  // parents before their children
  std::vector<uint32_t> order_;
};

}  // namespace livegs
