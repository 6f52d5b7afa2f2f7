// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// Finds the nearest of many equal, axis-aligned cubes (points, if their half width is 0) with a k-d tree over
// their centres. A uniform grid is slower for assets with distant haze, because a query visits most of its
// bins. Built once; queries may run on any thread.
class NearestCubes {
 public:
  struct Neighbour {
    float distance_squared = 0.0f;  // to the cube's surface; 0 inside
    uint32_t index = 0;
  };

  // Preconditions: at least one centre, all finite; half_width >= 0.
  NearestCubes(std::span<const Eigen::Vector3f> centres, float half_width);

  // Fills `nearest`, nearest first, up to its size or the number of cubes; returns the number found. Ties are
  // in order of index.
  size_t find(const Eigen::Vector3f& point, std::span<Neighbour> nearest) const;

 private:
  // Bounds of the centres in the subtree. Node n has children 2n + 1 and 2n + 2, each with half of its
  // centres.
  struct Node {
    Eigen::Vector3f low;
    Eigen::Vector3f high;
  };
  struct Search;

  void build(size_t node, size_t begin, size_t end, std::span<const Eigen::Vector3f> centres);
  void descend(size_t node, size_t begin, size_t end, Search& search) const;
  float distance_squared(size_t node, const Eigen::Vector3f& point) const;

  float half_width_;
  std::vector<Node> nodes_;
  std::vector<uint32_t> indices_;         // index in the caller's list, in leaf order
  std::vector<Eigen::Vector3f> centres_;  // in leaf order
};

}  // namespace livegs
