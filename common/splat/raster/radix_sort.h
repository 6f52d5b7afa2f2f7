// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Depth sort of the CPU renderer: raster/rasterise.cpp makes the keys in project() and calls radix_sort() in
// sort(). The Vulkan renderer sorts with key_sorter.h; both use ordered_key() of key_order.h.

namespace livegs {

struct KeyedIndex {
  uint32_t key;
  uint32_t index;
};

// Sorts ascending by key; stable. Three passes of 11 bits; a pass with equal digits is skipped. `scratch` is
// resized to the length of the items; its contents are lost.
void radix_sort(std::vector<KeyedIndex>& items, std::vector<KeyedIndex>& scratch);

}  // namespace livegs
