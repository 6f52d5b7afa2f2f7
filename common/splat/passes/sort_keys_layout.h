// SPDX-License-Identifier: Apache-2.0

// Data of the passes sort_count, sort_scan and sort_scatter. Shared by C++ and GLSL.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

const uint kSortGroup = 256;               // invocations per group; one group per tile
const uint kSortKeysPerThread = 8;         // consecutive keys
const uint kSortTile = 2048;               // keys
const uint kSortDigits = 16;               // per pass: 4 bits
const uint kSortDroppedKey = 0xffffffffu;  // not the key of any float except a NaN

const uint kSortFirstPass = 1u;    // the count is in the constants, not yet in the drawn row
const uint kSortIndexValues = 2u;  // values are the indices of the keys; none are read
const uint kSortDropsKeys = 4u;    // kSortDroppedKey and its value are removed

struct SortKeysConstants {
  uint key_count;      // before the first pass
  uint tile_capacity;  // tiles per row of the table
  uint shift;          // bit position of the digit
  uint flags;
};

// Number of remaining keys, as a VkDrawIndirectCommand: one instance per key, each a strip of four vertices.
struct SortedCount {
  uint vertex_count;    // 4
  uint instance_count;  // keys
  uint first_vertex;    // 0
  uint first_instance;  // 0
};

#ifdef __cplusplus
static_assert(kSortTile == kSortGroup * kSortKeysPerThread);
static_assert(sizeof(SortKeysConstants) == 16 && sizeof(SortedCount) == 16);
}  // namespace livegs
#endif
