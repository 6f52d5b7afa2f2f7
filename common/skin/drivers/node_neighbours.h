// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace livegs {

// Which nodes of a lattice stand beside each other at rest. Made once, where the lattice is, and shared by
// all that look; a stream predicts a node from those before it (wire/grid_coder.h).
struct NodeNeighbours {
  // Of a node: those one cell below it along x, y and z that have a lower index than it, and how many there
  // are. Places without one hold the number of nodes, so that an array with a zero at its end can be summed
  // over all three.
  struct Before {
    std::array<uint32_t, 3> nodes;
    uint32_t count;
  };
  std::vector<Eigen::Vector3i> coordinates;  // in cells, within +-kMaxNodeCoordinate
  std::vector<Before> before;                // one a node
};
using NodeNeighboursPtr = std::shared_ptr<const NodeNeighbours>;

inline constexpr int kMaxNodeCoordinate = (1 << 20) - 1;

// Null where a coordinate is out of range. Of several nodes at one place the one of the next lower index is
// taken.
NodeNeighboursPtr find_node_neighbours(std::vector<Eigen::Vector3i> coordinates);

// Whether both are the same, or neither is there.
bool same_neighbours(const NodeNeighboursPtr& a, const NodeNeighboursPtr& b);

}  // namespace livegs
