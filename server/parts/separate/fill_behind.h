// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "gaussian/gaussian_asset.h"
#include "parts/room_parts.h"
#include "parts/separate/split_straddling.h"

// Hidden surfaces behind and below a thing: the covered plane is continued, and the underside is closed.

namespace livegs {

struct BehindThing {
  GaussianAsset fill;            // flat kernels for the room
  std::vector<uint32_t> hidden;  // kernels of the room that the fill replaces
  struct Relit {
    uint32_t kernel;  // of the room
    float light;      // share of the light that the thing does not block, under 1
  };
  std::vector<Relit> relit;  // kernels of the room in the shade of the thing
  GaussianAsset underside;   // flat kernels for the thing
};

// 1. A picture of the room without the thing, looking straight at the plane. The hole is the foot of the
//    thing and a margin, in which kernels of the room carry colours of the thing.
// 2. The light of the plane around the thing is fitted by 1 - shade exp(-distance / reach), and the picture
//    is made without this shade.
// 3. The disc of the plane whose rim fits the rim of the hole best gives its texture (exemplar), and the
//    difference at the rim is continued into the hole by Laplace's equation (Pérez et al. 2003, Poisson image
//    editing, for a seamless rim).
// 4. One flat kernel per two pixels in both directions, in the plane.
// `part` is an index of parts.parts. Deterministic.
BehindThing fill_behind(const SplitRoom& room, const RoomParts& parts, size_t part);

}  // namespace livegs
