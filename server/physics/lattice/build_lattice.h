// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "physics/lattice/lattice.h"

// Steps of build_lattice: links between the boxes of material, separate cells and nodes for parts of a body
// that are close but not connected (Molino et al. 2004, "A virtual node algorithm for changing mesh topology
// during simulation"; Nesme et al. 2009, "Preserving topology and elasticity for embedded deformable
// models"), and thin shapes.
//
//     | A |  | B |       Two fingers in one row of cells. They are not connected within the cell, so each
//   +-|---|--|---|-+     has its own cell there, with its own upper nodes. They are connected in the palm
//   | |   |  |   | |     below: both cells share the nodes of that row.
//   +-|---|--|---|-+
//     |   palm   |

namespace livegs {

// Eigenvectors (columns), whose signs are arbitrary, with the largest entry of each positive.
Eigen::Matrix3d with_positive_entries(Eigen::Matrix3d axes);

// Pairs i < j of BodyExtent::boxes, ascending. Two boxes are linked if the gap between them along every axis
// is at most half a box edge. Shared edges and corners count as links and jittered grids stay connected, but
// a missing row of voxels is a gap. Separate parts are then linked to the rest across the gaps between them,
// narrowest first, up to `max_gap_m`, so that scattered points still form one body.
using BoxLinks = std::vector<std::pair<uint32_t, uint32_t>>;
BoxLinks link_boxes(const BodyExtent& extent, double max_gap_m);

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
// around that node connect them. Uses at most `colour_count` colours; if they are not enough, materials of
// one cell are merged.
VirtualCells make_virtual_cells(std::span<const BoxInCell> entries, const BoxLinks& links,
                                uint32_t colour_count);

// Sets LatticeCell::thin. The shape is that of the connected material in a cube of one cell width about the
// cell's centroid. The cell's own content is not enough: the fragment of a sheet in a corner of a cell does
// not show the shape of the sheet. `origin_m` is the position of lattice coordinates 0, lattice axes.
void find_thin_shapes(const BodyExtent& extent, const BoxLinks& links, std::span<const BoxInCell> entries,
                      std::span<const uint32_t> cell_of_entry, const Eigen::Vector3d& origin_m,
                      Lattice& lattice);

}  // namespace livegs
