// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"
#include "parts/separate/split_straddling.h"

// What no view has seen behind and below a thing: the plane it covers is continued, and its underside closed.

namespace livegs {

struct FilledPlane {
  bool wall = false;
  size_t plane = 0;        // index in supports or walls
  size_t hole_pixels = 0;  // of the picture from above; one pixel is RoomParts::footprint_m wide
  bool textured = false;   // false: no free disc of the plane was found, the mean of the ring was used
};

struct BehindThing {
  GaussianAsset fill;               // flat kernels for the room
  std::vector<uint32_t> hidden;     // kernels of the room that no view saw and that the fill replaces
  GaussianAsset underside;          // flat kernels for the thing
  std::vector<FilledPlane> planes;  // those that were continued
  bool unfilled = false;            // the thing touches no plane: nothing was filled
};

// 1. A picture of the room without the thing, looking straight at the plane. A pixel is a hole if the surface
//    there is not the plane, or is of kernels that no view saw.
// 2. The disc of the plane whose rim fits the rim of the hole best gives its texture (exemplar), and the
//    difference at the rim is continued into the hole by Laplace's equation (Pérez et al. 2003, Poisson image
//    editing, for a seamless rim).
// 3. One flat kernel per two pixels in both directions, in the plane.
// `part` is an index of parts.parts. Deterministic.
BehindThing fill_behind(const SplitRoom& room, const RoomParts& parts, size_t part);

}  // namespace livegs
