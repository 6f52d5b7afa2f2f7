// SPDX-License-Identifier: Apache-2.0

// Words of a shadow table (shadow_table.h). Shared by C++ and GLSL. Floats are stored as their bits; places
// are indices of words.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

// Header: a level grid over all bodies. The bodies over cell (x, z) are listed from word start[z * cells_x +
// x] to the next start; an entry is the place of a body.
const uint kShadowGridX = 0;       // m, float
const uint kShadowGridZ = 1;       // m, float
const uint kShadowGridScale = 2;   // cells per metre, float
const uint kShadowGridCellsX = 3;  // 0: no shadows
const uint kShadowGridCellsZ = 4;
const uint kShadowGridStarts = 5;  // place of the starts
const uint kShadowHeaderWords = 8;

// A body: darkness over a grid of nx * nz texels at four heights.
const uint kShadowObject = 0;  // object id; kernels of this object are not darkened
const uint kShadowX = 1;       // centre of texel (0, 0), m, float
const uint kShadowZ = 2;
const uint kShadowScale = 3;    // texels per metre, float
const uint kShadowTexelsX = 4;  // at least 2
const uint kShadowTexelsZ = 5;
const uint kShadowTexels = 6;   // place of the texels: four floats each, one per height, row by row along x
const uint kShadowHeights = 7;  // 6 floats, m, descending: no darkness, the four heights, no darkness
const uint kShadowSlopes = 13;  // 5 floats, 1/m: reciprocal differences of the heights
const uint kShadowBodyWords = 20;

#ifdef __cplusplus
}  // namespace livegs
#endif
