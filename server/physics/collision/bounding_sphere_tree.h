// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// Points in nested groups, each within a ball, so that those far from a surface are passed over many at a
// time. Holds indices only; immutable after building, any thread may ask.
class BoundingSphereTree {
 public:
  BoundingSphereTree() = default;
  explicit BoundingSphereTree(std::span<const Eigen::Vector3d> points_m);

  // Appends to `found` the indices, in ascending order, of all points that may lie within `reach_m` of a
  // surface, and of some that do not. `clearance_m(p)`, in the frame of the points, is never more than the
  // distance to it.
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
    uint32_t begin, end;  // of order_
    uint32_t after;       // the next group that is not within this one
  };
  void add_group(std::span<const Eigen::Vector3d> points_m, uint32_t begin, uint32_t end);

  std::vector<Group> groups_;  // parents before their children
  std::vector<uint32_t> order_;
};

}  // namespace livegs
