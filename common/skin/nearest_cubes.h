// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace livegs {

// Finds the nearest of many equal, axis-aligned cubes (of points, when their half width is 0) by a uniform grid over
// their centres. Built once; queries may come from any thread. Answers depend on the centres and their order only.
class NearestCubes {
 public:
  struct Neighbour {
    float distance_squared = 0.0f;  // to the cube's surface; 0 inside
    uint32_t index = 0;
  };

  // Preconditions: at least one centre, all finite; half_width >= 0.
  NearestCubes(std::span<const Eigen::Vector3f> centres, float half_width);

  // Fills `nearest`, nearest first, with as many as it holds or as there are, and returns how many. Of two at the
  // same distance the lower index comes first.
  size_t find(const Eigen::Vector3f& point, std::span<Neighbour> nearest) const;

 private:
  Eigen::Vector3i bin_of(const Eigen::Vector3f& point_in_box) const;
  void search_bin(int x, int y, int z, const Eigen::Vector3f& point, std::span<Neighbour> nearest,
                  size_t& found) const;

  float half_width_;
  float bin_width_;
  Eigen::Vector3f min_;
  Eigen::Vector3f max_;
  Eigen::Vector3i bins_;
  std::vector<uint32_t> bin_begin_;           // one more than there are bins
  std::vector<Eigen::Vector3f> centres_;      // sorted by bin, by index within a bin
  std::vector<uint32_t> indices_;             // of the caller, in that order
};

}  // namespace livegs
