// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gaussian/gaussian_asset.h"

// The sample scene: Gaussian assets made in code, so that the repository ships no captured data and a
// newcomer has something to touch. Each looks like a good capture: surface-aligned kernels, procedural
// texture, baked light, view-dependent gloss.
//
// All are in metres and in the frame of GaussianAsset (x right, -Y up, z forward). An object stands with its
// base at y = 0 and extends to negative y; its middle is at x = z = 0. With scale 1 and up "-y" it stands
// upright in a scene. Light falls from the right, above and the viewer's side (asset direction 0.53, -0.69,
// -0.50), the same on all. The same seed gives the same bits; another seed another specimen of the same
// things. Any thread.

namespace livegs {

struct SampleAsset {
  std::string name;  // also a good file name: cup, pillow, hat, plant, duck, stool, room
  GaussianAsset asset;
};

GaussianAsset make_cup(uint64_t seed = 1);     // glazed stoneware, hollow, handle; 0.10 m high
GaussianAsset make_pillow(uint64_t seed = 1);  // striped linen with piping; 0.45 m square, 0.15 m high, lying
GaussianAsset make_felt_hat(uint64_t seed = 1);  // hollow felt with a ribbon; brim 0.30 m across, 0.13 m high
GaussianAsset make_potted_plant(uint64_t seed = 1);  // arching striped blades in terracotta; 0.50 m high
GaussianAsset make_toy_duck(uint64_t seed = 1);  // bath duck of soft vinyl, facing the viewer; 0.12 m high
GaussianAsset make_wooden_stool(uint64_t seed = 1);  // four turned legs, stretchers; 0.45 m high

// Floor 3 m x 3 m at y = 0, centred at x = z = 0, and two walls 2.4 m high: one at z = +1.5 (before a viewer
// who looks along +z), one at x = -1.5 (on the left). The corner is at x = -1.5, z = +1.5; objects within 1.2
// m of the middle stand free of the walls. In a y-up world the back wall is at z = -1.5.
GaussianAsset make_room_corner(uint64_t seed = 1);

// The seven above, objects first; the last one, "room", is background.
std::vector<SampleAsset> make_sample_assets(uint64_t seed = 1);

}  // namespace livegs
