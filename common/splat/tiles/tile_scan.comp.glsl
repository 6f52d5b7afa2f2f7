// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/sort_keys_layout.h"
#include "splat/tiles/tile_splats_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) restrict buffer Sums { uint sums[]; };
layout(std430, set = 0, binding = 1) writeonly restrict buffer Pairs { SortedCount pairs; };
layout(std430, set = 0, binding = 2) writeonly restrict buffer Picture { uint picture[]; };
layout(push_constant) uniform Constants { TileScanConstants constants; };

shared uint totals[kTileGroup];

uint saturated_sum(uint a, uint b) {
  const uint sum = a + b;
  return sum < a ? 0xffffffffu : sum;
}

// A single group replaces each sum by the sum of those before it. Sums stop at 2^32 - 1.
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const uint stretch = (constants.block_count + kTileGroup - 1) / kTileGroup;
  const uint begin = min(thread * stretch, constants.block_count);
  const uint end = min(begin + stretch, constants.block_count);
  uint sum = 0;
  for (uint i = begin; i < end; ++i) sum = saturated_sum(sum, sums[i]);
  totals[thread] = sum;
  barrier();
  for (uint reach = 1; reach < kTileGroup; reach *= 2) {
    const uint before = thread >= reach ? totals[thread - reach] : 0;
    barrier();
    totals[thread] = saturated_sum(totals[thread], before);
    barrier();
  }
  uint next = thread > 0 ? totals[thread - 1] : 0;
  for (uint i = begin; i < end; ++i) {
    const uint here = sums[i];
    sums[i] = next;
    next = saturated_sum(next, here);
  }
  if (thread == kTileGroup - 1) {
    pairs = SortedCount(4, min(totals[thread], constants.pair_capacity), 0, 0);
    picture[0] = totals[thread];
  }
}
