// SPDX-License-Identifier: Apache-2.0

// What the passes sort_count, sort_scan and sort_scatter share, for C++ and GLSL alike.

#ifdef __cplusplus
#pragma once
#include <cstdint>
namespace livegs {
using uint = uint32_t;
#endif

const uint kSortGroup = 256;               // invocations; one group a tile
const uint kSortKeysPerThread = 8;         // consecutive ones
const uint kSortTile = 2048;               // keys
const uint kSortDigits = 16;               // of a pass: 4 bits
const uint kSortDroppedKey = 0xffffffffu;  // of no float but a NaN

const uint kSortFirstPass = 1u;    // the count stands in the constants, not yet in the drawn row
const uint kSortIndexValues = 2u;  // values are the keys' own places; none are read
const uint kSortDropsKeys = 4u;    // kSortDroppedKey and its value are left out

struct SortKeysConstants {
  uint key_count;      // before the first pass
  uint tile_capacity;  // tiles of a row of the table
  uint shift;          // of the digit, bits
  uint flags;
};

// How many keys are left, as VkDrawIndirectCommand has it: one instance a key, each a strip of four vertices.
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
