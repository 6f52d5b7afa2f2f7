// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/pass.h"
#include "splat/passes/project_splats_layout.h"
#include "splat/passes/sort_keys_layout.h"
#include "splat/tiles/tile_splats_layout.h"

namespace livegs {

// Passes of frame_tiles.h; an item is a thread of a group.
// rows 0, rows 1, rows 2, order, SortedCount of the kernels, sums of the blocks, tiles, places.
const Pass& tile_pairs_pass();
// sums of the blocks, SortedCount of the pairs, picture.
const Pass& tile_scan_pass();
// tiles in order, SortedCount of the pairs, first pair of each tile and of the end.
const Pass& tile_ranges_pass();
// rows 0, rows 1, rows 2, places in the order of the tiles, first pairs, picture.
const Pass& tile_blend_pass();

}  // namespace livegs
