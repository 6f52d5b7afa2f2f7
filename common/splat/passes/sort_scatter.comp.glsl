// SPDX-License-Identifier: Apache-2.0
#version 460
#extension GL_GOOGLE_include_directive : require
#include "splat/passes/sort_keys_layout.h"

layout(local_size_x_id = 0) in;
layout(std430, set = 0, binding = 0) readonly restrict buffer Keys { uint keys[]; };
layout(std430, set = 0, binding = 1) readonly restrict buffer Values { uint values[]; };
layout(std430, set = 0, binding = 2) readonly restrict buffer Table { uint table[]; };
layout(std430, set = 0, binding = 3) restrict buffer Counted { SortedCount counted; };
layout(std430, set = 0, binding = 4) writeonly restrict buffer SortedKeys { uint sorted_keys[]; };
layout(std430, set = 0, binding = 5) writeonly restrict buffer SortedValues { uint sorted_values[]; };
layout(push_constant) uniform Constants { SortKeysConstants constants; };

const uint kRows = kSortDigits / 2;  // a row of counters for two digits, one per half word
const uint kLanes = kSortGroup / kRows;  // threads that scan a row together
const uint kStretch = kSortGroup / kLanes;  // counters per thread

// ranks[row][thread]: number of keys of the row's digits in the threads before this one. A tile has 2048
// keys, so a half word cannot overflow.
shared uint ranks[kRows * kSortGroup];
shared uint sums[kSortGroup];
shared uint digit_begins[kSortDigits];

// Each thread counts its eight consecutive keys by digit; the counters are scanned over the threads; each
// thread visits its keys again. Equal digits keep their order, and no atomics are needed.
void main() {
  const uint thread = gl_LocalInvocationID.x;
  const uint tile = gl_WorkGroupID.x;
  const bool first_pass = (constants.flags & kSortFirstPass) != 0;
  // The first pass writes the number of remaining keys, but all keys are still stored.
  const uint count = first_pass ? constants.key_count : counted.instance_count;
  const bool drops = (constants.flags & kSortDropsKeys) != 0;
  const uint begin = min(tile * kSortTile + thread * kSortKeysPerThread, count);
  const uint end = min(begin + kSortKeysPerThread, count);

  if (thread < kSortDigits) {
    uint before = 0;
    for (uint digit = 0; digit < thread; ++digit) before += table[kSortDigits * constants.tile_capacity + digit];
    digit_begins[thread] = before;
    if (first_pass && tile == 0 && thread == kSortDigits - 1) {
      counted = SortedCount(4, before + table[kSortDigits * constants.tile_capacity + thread], 0, 0);
    }
  }
  for (uint row = 0; row < kRows; ++row) ranks[row * kSortGroup + thread] = 0;
  for (uint i = begin; i < end; ++i) {
    const uint key = keys[i];
    if (drops && key == kSortDroppedKey) continue;
    const uint digit = (key >> constants.shift) % kSortDigits;
    ranks[digit / 2 * kSortGroup + thread] += 1u << (16 * (digit % 2));
  }
  barrier();

  const uint lane = thread % kLanes;
  const uint stretch = thread * kStretch;  // rows are consecutive, and so are ranges
  uint sum = 0;
  for (uint i = stretch; i < stretch + kStretch; ++i) sum += ranks[i];
  sums[thread] = sum;
  barrier();
  for (uint reach = 1; reach < kLanes; reach *= 2) {
    const uint before = lane >= reach ? sums[thread - reach] : 0;
    barrier();
    sums[thread] += before;
    barrier();
  }
  uint next = sums[thread] - sum;
  for (uint i = stretch; i < stretch + kStretch; ++i) {
    const uint here = ranks[i];
    ranks[i] = next;
    next += here;
  }
  barrier();

  for (uint i = begin; i < end; ++i) {
    const uint key = keys[i];
    if (drops && key == kSortDroppedKey) continue;
    const uint digit = (key >> constants.shift) % kSortDigits;
    const uint half_word = 16 * (digit % 2);
    const uint counter = digit / 2 * kSortGroup + thread;
    const uint place = digit_begins[digit] + table[digit * constants.tile_capacity + tile] + ((ranks[counter] >> half_word) & 0xffffu);
    ranks[counter] += 1u << half_word;
    sorted_keys[place] = key;
    sorted_values[place] = (constants.flags & kSortIndexValues) != 0 ? i : values[i];
  }
}
