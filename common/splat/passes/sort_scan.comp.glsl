// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/sort_keys_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) restrict buffer Table { uint table[]; };
layout(std430, set = 0, binding = 1) writeonly restrict buffer Counted { SortedCount counted; };
layout(push_constant) uniform Constants { SortKeysConstants constants; };

shared uint sums[kSortGroup];

// A single group replaces each entry of the table by the sum of those before it. Each thread sums a range;
// the sums of the ranges are scanned by doubling (Hillis and Steele 1986).
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const uint entries = kSortDigits * constants.tile_capacity;
  const uint stretch = (entries + kSortGroup - 1) / kSortGroup;
  const uint begin = min(thread * stretch, entries);
  const uint end = min(begin + stretch, entries);
  uint sum = 0;
  for (uint i = begin; i < end; ++i) sum += table[i];
  sums[thread] = sum;
  barrier();
  for (uint reach = 1; reach < kSortGroup; reach *= 2) {
    const uint before = thread >= reach ? sums[thread - reach] : 0;
    barrier();
    sums[thread] += before;
    barrier();
  }
  uint next = sums[thread] - sum;
  for (uint i = begin; i < end; ++i) {
    const uint here = table[i];
    table[i] = next;
    next += here;
  }
  if (thread == kSortGroup - 1 && (constants.flags & kSortFirstPass) != 0) {
    counted = SortedCount(4, sums[thread], 0, 0);
  }
}
