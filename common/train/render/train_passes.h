// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "compute/pass.h"
#include "train/render/train_blend_layout.h"

namespace livegs {

// Passes of device_blender.h. Rows, depths and ranks are by kernel, nearest first; pairs are those of
// TilePairs with keeps_unsorted. rows, depths, rank of each pair, pairs by tile, first pair of each tile,
// picture.
const Pass& train_blend_pass();
// the same, gradient by the picture, gradient by the pairs.
const Pass& train_backward_pass();
// first pair of each kernel, gradient by the pairs, gradient by the kernels.
const Pass& train_gather_pass();

}  // namespace livegs
