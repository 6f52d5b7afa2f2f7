// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

// Separate cells and nodes for parts of a body that are close but not connected (Molino et al. 2004, "A
// virtual node algorithm for changing mesh topology during simulation"; Nesme et al. 2009, "Preserving
// topology and elasticity for embedded deformable models").
//
//     | A |  | B |       Two fingers in one row of cells. They are not connected within the cell, so each
//   +-|---|--|---|-+     has its own cell there, with its own upper nodes. They are connected in the palm
//   | |   |  |   | |     below: both cells share the nodes of that row.
//   +-|---|--|---|-+
//     |   palm   |

namespace livegs {

// Marks a box with material in a cell. Entries of one box are consecutive; a cell occurs once per box.
struct BoxInCell {
  uint32_t box;
  Eigen::Vector3i cell;
};

struct VirtualCells {
  struct Cell {
    Eigen::Vector3i coordinates;
    std::array<uint32_t, 8> nodes;
    uint32_t colour;  // cells of one colour share no node; 0 ... 7 by parity, others above
  };
  std::vector<Cell> cells;                        // by colour, then z, y, x, then first entry
  std::vector<Eigen::Vector3i> node_coordinates;  // by z, y, x
  std::vector<uint32_t> cell_of_entry;
};

// Boxes of one cell form one material if they are linked. Two materials share a node of their cells if links
// around that node connect them. `links` are those of link_boxes. Uses at most `colour_count` colours; if
// they are not enough, materials of one cell are merged.
VirtualCells make_virtual_cells(std::span<const BoxInCell> entries,
                                std::span<const std::pair<uint32_t, uint32_t>> links, uint32_t colour_count);

}  // namespace livegs
