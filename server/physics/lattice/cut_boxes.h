// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <span>

#include "physics/body_region.h"
#include "physics/lattice/lattice.h"

// Cuts the boxes of a body by the planes of a lattice and the faces of regions. A particle is a box along the
// lattice axes, and lattice planes cut a box into boxes, so the moments of the material in each cell are
// exact. Point samples of the particles would alias with the lattice.

namespace livegs {

// A slice of a box thinner than this fraction of a cell goes to the neighbouring cell, and a thinner outer
// layer of a body is dropped, so that rounding does not create nearly empty cells.
inline constexpr double kMinSlice = 1e-3;

// A box or a part of it, within one cell.
struct BoxPiece {
  uint32_t box;          // box index in BodyExtent::boxes
  Eigen::Vector3i cell;  // lattice planes are at integers, relative to the given origin
  double volume_m3;
  Eigen::Vector3d mean, mean_square;  // of the local coordinates, -1 ... 1
  uint16_t material = 0;              // 0: the body's own; k: of the k-th region that has a material
  bool fixed = false;                 // in a fixed region
};

// One for the body, plus one per region that has a material.
size_t material_count(std::span<const BodyRegion> regions);

// Whether the lattice axes are the object's axes, so that region faces are planes of constant coordinate.
bool along_object_axes(const BodyExtent& extent);
Eigen::AlignedBox3d in_object_axes(const BodyExtent& extent, const MassBox& box);  // bounds of the corners

// Calls `take` for every piece, box by box. If the lattice is along the object's axes, regions cut boxes
// exactly at their faces. Otherwise a box that straddles a face is divided into quarters along each edge, and
// the centre of each part decides its region.
void cut_boxes(const BodyExtent& extent, const Eigen::Vector3d& origin_m, double cell_width_m,
               std::span<const BodyRegion> regions, const std::function<void(const BoxPiece&)>& take);

}  // namespace livegs
