// SPDX-License-Identifier: Apache-2.0

// Data of the passes tile_pairs, tile_scan, tile_ranges and tile_blend. Shared by C++ and GLSL.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

const uint kTileGroup = 256;      // invocations per group: the kernels of a block, or the pixels of a tile
const uint kTileEdge_px = 16;     // of a square tile
const uint kTileHeaderWords = 4;  // before the pixels of a picture: the number of pairs; the rest is unused

// A block is kTileGroup kernels in draw order. A pair is a tile and a kernel that touches it.
struct TilePairsConstants {
  uint eye;
  uint block_capacity;  // blocks per eye in the sums
  uint part_rows;       // rows per buffer, as in FrameSplats
  uint pair_capacity;   // 0: only the sum of each block is written
  uint width_px;
  uint height_px;
  uint no_tile;               // written where rounding finds fewer tiles than were counted; above all tiles
  float log2_of_least_alpha;  // a kernel ends where its alpha falls below it
};

struct TileScanConstants {
  uint block_count;  // of all eyes
  uint pair_capacity;
};

struct TileRangesConstants {
  uint tile_count;  // of all eyes
};

struct TileBlendConstants {
  uint eye;
  uint part_rows;
  uint width_px;
  uint height_px;
  float red;  // background
  float green;
  float blue;
  uint floats;  // 1: four floats per pixel, premultiplied without background; 0: RGBA8 over the background
};

#ifdef __cplusplus
static_assert(sizeof(TilePairsConstants) == 32 && sizeof(TileScanConstants) == 8);
static_assert(sizeof(TileRangesConstants) == 4 && sizeof(TileBlendConstants) == 32);
}  // namespace livegs
#endif
