// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"

// The sample scene: Gaussian assets generated in code, so that the repository contains no captured data. Each
// resembles a good capture: surface-aligned kernels, procedural texture, baked light and view-dependent
// gloss.
//
// Units are metres, in the frame of GaussianAsset (x right, -Y up, z forward). The base of an object is at y
// = 0 and it extends to negative y; its centre is at x = z = 0. With scale 1 and up "-y" it stands upright in
// a scene. The light comes from the right, above and the viewer's side (asset direction 0.53, -0.69, -0.50)
// for all assets. Equal seeds give the same bits; other seeds give other details. Any thread.

namespace livegs {

struct SampleAsset {
  std::string name;  // also used as a file name: cup, pillow, hat, plant, duck, stool, room
  GaussianAsset asset;
};

GaussianAsset make_cup(uint64_t seed = 1);     // glazed stoneware, hollow, handle; 0.10 m high
GaussianAsset make_pillow(uint64_t seed = 1);  // striped linen with piping; 0.45 m square, 0.15 m high, lying
GaussianAsset make_felt_hat(uint64_t seed = 1);  // hollow felt with a ribbon; brim 0.30 m across, 0.13 m high
GaussianAsset make_potted_plant(uint64_t seed = 1);  // arching striped blades in terracotta; 0.50 m high
GaussianAsset make_toy_duck(uint64_t seed = 1);  // bath duck of soft vinyl, facing the viewer; 0.12 m high
GaussianAsset make_wooden_stool(uint64_t seed = 1);  // four turned legs, stretchers; 0.45 m high

// A floor of 3 m x 3 m at y = 0, centred at x = z = 0, and two walls 2.4 m high: one at z = +1.5, in front of
// a viewer who looks along +z, and one at x = -1.5, on the left. Objects within 1.2 m of the centre do not
// touch the walls. In a y-up world the back wall is at z = -1.5.
GaussianAsset make_room_corner(uint64_t seed = 1);

// Makes the seven assets above, objects first; the last one, "room", is the background.
std::vector<SampleAsset> make_sample_assets(uint64_t seed = 1);

}  // namespace livegs
