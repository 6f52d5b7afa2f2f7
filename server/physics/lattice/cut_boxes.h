// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <span>

#include "physics/body_region.h"
#include "physics/lattice/lattice.h"

// The boxes of a body cut by the planes of a lattice and by the faces of regions. A particle is a box along
// the lattice axes, and a box cut by lattice planes is again boxes: so the moments of the material in each
// cell are exact. (Point samples of the particles alias with the lattice, elastic-study.md 2.1.)

namespace livegs {

// A box, whole or cut, within one cell.
struct BoxPiece {
  uint32_t box;          // BodyExtent::boxes
  Eigen::Vector3i cell;  // lattice planes stand at whole numbers, from the origin given
  double volume_m3;
  Eigen::Vector3d mean, mean_square;  // of the local coordinates, -1 ... 1
  uint16_t material;                  // 0: the body's own; k: of the k-th region that has a material
  bool fixed;                         // in a fixed region
};

// The body's own and one a region that has a material.
size_t material_count(std::span<const BodyRegion> regions);

// Whether the lattice lies along the object's axes, so that faces of regions are planes of constant
// coordinate.
bool along_object_axes(const BodyExtent& extent);

// Calls `take` for every piece, box by box. Regions cut boxes exactly at their faces where the lattice lies
// along the object's axes; else a box that straddles a face is cut into quarters along each edge, each wholly
// where its centre is.
void cut_boxes(const BodyExtent& extent, const Eigen::Vector3d& origin_m, double cell_width_m,
               std::span<const BodyRegion> regions, const std::function<void(const BoxPiece&)>& take);

}  // namespace livegs
