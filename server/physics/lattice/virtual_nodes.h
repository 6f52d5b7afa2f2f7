// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

// Cells and nodes for parts of a body that touch only in the picture (Molino et al. 2004, "A virtual node
// algorithm for changing mesh topology during simulation"; Nesme et al. 2009, "Preserving topology and
// elasticity for embedded deformable models").
//
//     | A |  | B |      Two fingers in one row of cells. Inside the cell they do not hang together, so each
//     has a cell
//   +-|---|--|---|-+    of its own there, with upper nodes of its own. Below, in the palm, they do: the cells
//   of both | |   |  |   | |    share the nodes of that row.
//   +-|---|--|---|-+
//     |   palm   |

namespace livegs {

// A box has material in a cell. Entries of one box follow each other, no cell twice.
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

// The material in one cell is one as far as boxes in it are linked; two such materials share a node of their
// cells as far as links around that node join them. `links` as link_boxes gives them. At most `colour_count`
// colours: where those do not suffice, materials in one cell are joined.
VirtualCells make_virtual_cells(std::span<const BoxInCell> entries,
                                std::span<const std::pair<uint32_t, uint32_t>> links, uint32_t colour_count);

}  // namespace livegs
