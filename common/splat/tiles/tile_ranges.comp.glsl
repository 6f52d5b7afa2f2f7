// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/sort_keys_layout.h"
#include "splat/tiles/tile_splats_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Tiles { uint tiles[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Pairs { SortedCount pairs; };
layout(std430, set = 0, binding = 2) writeonly restrict buffer Firsts { uint firsts[]; };
layout(push_constant) uniform Constants { TileRangesConstants constants; };

// The first pair of each tile, and of the end: a binary search in the sorted tiles.
void main() {
  const uint tile = gl_GlobalInvocationID.x;
  if (tile > constants.tile_count) return;
  uint begin = 0;
  uint end = pairs.instance_count;
  while (begin < end) {
    const uint middle = begin + (end - begin) / 2;
    if (tiles[middle] < tile) {
      begin = middle + 1;
    } else {
      end = middle;
    }
  }
  firsts[tile] = begin;
}
