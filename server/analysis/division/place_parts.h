// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "analysis/division/part_places.h"
#include "analysis/estimate.h"

namespace livegs {

// Gives parts their boxes by a label per kernel (label_boxes.h). `holder[i]` is the part that encloses part
// i, such as the pot of its soil: its box is that of the holder without a wall, up to its highest kernel, or
// to the top of the holder if none is seen. Enclosed parts must come after their holders.
// Precondition: one label per kernel, at most kMaxMaterialParts parts.
void place_parts(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                 std::span<const std::optional<size_t>> holder, MaterialParts& parts);

}  // namespace livegs
