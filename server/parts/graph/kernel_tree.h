// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace livegs {

// A balanced k-d tree of points (Bentley 1975) with up to kLeaf points per leaf. Ties go to the lower index.
class KernelTree {
 public:
  explicit KernelTree(std::span<const Eigen::Vector3f> points);

  struct Neighbour {
    float distance2;
    uint32_t index;
    bool operator<(const Neighbour& other) const {
      return distance2 < other.distance2 || (distance2 == other.distance2 && index < other.index);
    }
  };
  // The `count` nearest points within the radius, nearest first; fewer if there are fewer. `found` is
  // replaced.
  void nearest(const Eigen::Vector3f& point, size_t count, std::vector<Neighbour>& found,
               float radius = std::numeric_limits<float>::infinity()) const;
  // All points within the radius, in an unspecified but fixed order. `found` is replaced.
  void within(const Eigen::Vector3f& point, float radius, std::vector<uint32_t>& found) const;

  size_t size() const { return order_.size(); }

 private:
  static constexpr uint32_t kLeaf = 12;
  struct Node {
    float split;
    uint32_t axis;
  };
  void build(uint32_t node, uint32_t begin, uint32_t end, std::span<const Eigen::Vector3f> points, int depth);

  // Node n covers a range whose halves are nodes 2n + 1 and 2n + 2; the ranges follow from the number of
  // points.
  std::vector<Node> nodes_;
  std::vector<uint32_t> order_;
  std::vector<Eigen::Vector3f> points_;  // in the order of order_
};

}  // namespace livegs
