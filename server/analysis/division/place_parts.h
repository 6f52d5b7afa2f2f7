// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "analysis/division/part_places.h"
#include "analysis/estimate.h"

namespace livegs {

// The part that encloses another one, such as the pot of its soil.
struct PartHolder {
  size_t part = 0;
  bool open = false;  // above: enclosed parts reach to its top
};

// Gives parts their boxes by a label per kernel (label_boxes.h). The box of an enclosed part is that of its
// holder without a wall, up to the highest kernel of the part, if any is seen. Enclosed parts must come after
// their holders.
// Precondition: one label per kernel, at most kMaxMaterialParts parts.
void place_parts(const SurfaceKernels& kernels, std::span<const uint8_t> labels,
                 std::span<const std::optional<PartHolder>> holder, MaterialParts& parts);

}  // namespace livegs
