// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/sort_keys_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) restrict buffer Table { uint table[]; };
layout(push_constant) uniform Constants { SortKeysConstants constants; };

shared uint sums[kSortGroup];

// One group per digit replaces each entry of its row by the sum of those before it, and writes the sum of the
// row behind the table. Each thread sums a range; the sums of the ranges are scanned by doubling (Hillis and
// Steele 1986).
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const uint digit = gl_WorkGroupID.x;
  const uint row = digit * constants.tile_capacity;
  const uint stretch = (constants.tile_capacity + kSortGroup - 1) / kSortGroup;
  const uint begin = min(thread * stretch, constants.tile_capacity);
  const uint end = min(begin + stretch, constants.tile_capacity);
  uint sum = 0;
  for (uint i = begin; i < end; ++i) sum += table[row + i];
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
    const uint here = table[row + i];
    table[row + i] = next;
    next += here;
  }
  if (thread == kSortGroup - 1) table[kSortDigits * constants.tile_capacity + digit] = sums[thread];
}
