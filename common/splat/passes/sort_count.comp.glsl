// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/sort_keys_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Keys { uint keys[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Counted { SortedCount counted; };
layout(std430, set = 0, binding = 2) writeonly restrict buffer Table { uint table[]; };
layout(push_constant) uniform Constants { SortKeysConstants constants; };

shared uint counts[kSortDigits];

// Counts each digit in each tile: table[digit][tile].
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const uint tile = gl_WorkGroupID.x;
  const uint count =
      (constants.flags & kSortFirstPass) != 0 ? constants.key_count : counted.instance_count;
  const bool drops = (constants.flags & kSortDropsKeys) != 0;
  if (thread < kSortDigits) counts[thread] = 0;
  barrier();
  for (uint i = 0; i < kSortKeysPerThread; ++i) {
    const uint place = tile * kSortTile + i * kSortGroup + thread;
    if (place >= count) break;
    const uint key = keys[place];
    if (!(drops && key == kSortDroppedKey)) atomicAdd(counts[(key >> constants.shift) % kSortDigits], 1);
  }
  barrier();
  if (thread < kSortDigits) table[thread * constants.tile_capacity + tile] = counts[thread];
}
