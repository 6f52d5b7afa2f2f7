// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace livegs {

// Adjacent nodes of a lattice at rest. Computed once per lattice and shared. Stream coding predicts a node
// from earlier neighbours (wire/grid_coder.h).
struct NodeNeighbours {
  // The neighbours one cell below a node along x, y and z that have a lower index, and their number. A
  // missing neighbour is the node count, so an array with a zero at its end can be summed over all three.
  struct Before {
    std::array<uint32_t, 3> nodes;
    uint32_t count;
  };
  std::vector<Eigen::Vector3i> coordinates;  // in cells, within ±kMaxNodeCoordinate
  std::vector<Before> before;                // one per node
};
using NodeNeighboursPtr = std::shared_ptr<const NodeNeighbours>;

inline constexpr int kMaxNodeCoordinate = (1 << 20) - 1;

// Null if a coordinate is out of range. If several nodes share a place, the one with the next lower index is
// the neighbour.
NodeNeighboursPtr find_node_neighbours(std::vector<Eigen::Vector3i> coordinates);

// Whether both are equal, or both are null.
bool same_neighbours(const NodeNeighboursPtr& a, const NodeNeighboursPtr& b);

}  // namespace livegs
