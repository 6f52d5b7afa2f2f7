// SPDX-License-Identifier: Apache-2.0
#include "skin/drivers/node_neighbours.h"

#include <algorithm>
#include <utility>

namespace livegs {
namespace {

constexpr uint64_t kAxisBits = 21;

// z, y, x from the highest bits down. A step along an axis never carries into the next field.
uint64_t key_of(const Eigen::Vector3i& c) {
  const auto part = [&](int axis) {
    return static_cast<uint64_t>(c[axis] + kMaxNodeCoordinate + 1) << (kAxisBits * axis);
  };
  return part(0) | part(1) | part(2);
}

}  // namespace

NodeNeighboursPtr find_node_neighbours(std::vector<Eigen::Vector3i> coordinates) {
  const auto n = static_cast<uint32_t>(coordinates.size());
  std::vector<std::pair<uint64_t, uint32_t>> places(n);
  for (uint32_t i = 0; i < n; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (coordinates[i][axis] < -kMaxNodeCoordinate || coordinates[i][axis] > kMaxNodeCoordinate)
        return nullptr;
    }
    places[i] = {key_of(coordinates[i]), i};
  }
  if (!std::is_sorted(places.begin(), places.end())) std::sort(places.begin(), places.end());
  auto found = std::make_shared<NodeNeighbours>();
  found->before.assign(n, {{n, n, n}, 0});
  for (uint64_t axis = 0; axis < 3; ++axis) {
    // Keys ascend, and so do the keys one cell below them: a single pass finds all neighbours.
    auto below = places.begin();
    for (const auto& [key, node] : places) {
      const uint64_t wanted = key - (uint64_t{1} << (kAxisBits * axis));
      while (below->first < wanted) ++below;
      uint32_t nearest = n;
      for (auto same = below; same->first == wanted && same->second < node; ++same) nearest = same->second;
      if (nearest == n) continue;
      NodeNeighbours::Before& before = found->before[node];
      before.nodes[before.count++] = nearest;
    }
  }
  found->coordinates = std::move(coordinates);
  return found;
}

bool same_neighbours(const NodeNeighboursPtr& a, const NodeNeighboursPtr& b) {
  return a == b || (a && b && a->coordinates == b->coordinates);
}

}  // namespace livegs
