// SPDX-License-Identifier: Apache-2.0
#include "skin/kernels/nearest_cubes.h"

#include <algorithm>
#include <numeric>

#include "core/assert.h"

namespace livegs {
namespace {

// Maximum centres per leaf. Smaller leaves make the tree deeper; larger ones cost more distance tests.
constexpr size_t kLeafSize = 8;

size_t middle_of(size_t begin, size_t end) { return begin + (end - begin) / 2; }

bool closer(const NearestCubes::Neighbour& a, const NearestCubes::Neighbour& b) {
  return a.distance_squared < b.distance_squared ||
         (a.distance_squared == b.distance_squared && a.index < b.index);
}

}  // namespace

struct NearestCubes::Search {
  Eigen::Vector3f point;
  std::span<Neighbour> nearest;
  size_t found = 0;

  // Follows equal distances too, so that the lowest index is always found.
  bool may_hold_nearer(float bound) const {
    return found < nearest.size() || bound <= nearest[found - 1].distance_squared;
  }

  void offer(const Neighbour& candidate) {
    if (found == nearest.size()) {
      if (!closer(candidate, nearest[found - 1])) return;
    } else {
      ++found;
    }
    size_t place = found - 1;
    for (; place > 0 && closer(candidate, nearest[place - 1]); --place) nearest[place] = nearest[place - 1];
    nearest[place] = candidate;
  }
};

NearestCubes::NearestCubes(std::span<const Eigen::Vector3f> centres, float half_width)
    : half_width_(half_width) {
  LIVEGS_ASSERT(!centres.empty());
  size_t deepest = 1;  // nodes of a tree whose largest leaf fits the limit
  for (size_t largest = centres.size(); largest > kLeafSize; largest -= largest / 2)
    deepest = 2 * deepest + 1;
  nodes_.resize(deepest);
  indices_.resize(centres.size());
  std::iota(indices_.begin(), indices_.end(), 0u);
  build(0, 0, centres.size(), centres);
  centres_.reserve(centres.size());
  for (const uint32_t index : indices_) centres_.push_back(centres[index]);
}

void NearestCubes::build(size_t node, size_t begin, size_t end, std::span<const Eigen::Vector3f> centres) {
  Eigen::Vector3f low = centres[indices_[begin]], high = low;
  for (size_t i = begin + 1; i < end; ++i) {
    low = low.cwiseMin(centres[indices_[i]]);
    high = high.cwiseMax(centres[indices_[i]]);
  }
  nodes_[node] = {low, high};
  if (end - begin <= kLeafSize) return;
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const size_t middle = middle_of(begin, end);
  const auto at = [this](size_t i) { return indices_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    return centres[a][axis] < centres[b][axis] || (centres[a][axis] == centres[b][axis] && a < b);
  });
  build(2 * node + 1, begin, middle, centres);
  build(2 * node + 2, middle, end, centres);
}

float NearestCubes::distance_squared(size_t node, const Eigen::Vector3f& point) const {
  // Rounds like the distance to a centre on the bound, so it never exceeds that of a cube inside.
  const Eigen::Array3f below = nodes_[node].low.array() - point.array(),
                       above = point.array() - nodes_[node].high.array();
  return (below.max(above) - half_width_).max(0.0f).matrix().squaredNorm();
}

void NearestCubes::descend(size_t node, size_t begin, size_t end, Search& search) const {
  if (end - begin <= kLeafSize) {
    for (size_t i = begin; i < end; ++i) {
      const Eigen::Array3f outside = ((search.point - centres_[i]).array().abs() - half_width_).max(0.0f);
      search.offer({outside.matrix().squaredNorm(), indices_[i]});
    }
    return;
  }
  const size_t middle = middle_of(begin, end);
  const float left = distance_squared(2 * node + 1, search.point),
              right = distance_squared(2 * node + 2, search.point);
  const bool left_first = left <= right;
  for (const bool go_left : {left_first, !left_first}) {
    if (!search.may_hold_nearer(go_left ? left : right)) continue;
    if (go_left) {
      descend(2 * node + 1, begin, middle, search);
    } else {
      descend(2 * node + 2, middle, end, search);
    }
  }
}

size_t NearestCubes::find(const Eigen::Vector3f& point, std::span<Neighbour> nearest) const {
  if (nearest.empty()) return 0;
  Search search{point, nearest};
  descend(0, 0, centres_.size(), search);
  return search.found;
}

}  // namespace livegs
