// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>

#include "analysis/division/part_places.h"
#include "analysis/estimate.h"
#include "analysis/knowledge/tables.h"

namespace livegs {

struct LooksDivision {
  bool divided = false;
  std::string reason;  // for the border, or for a single part
};

// Divides an object whose class has parts at usual places (ObjectPart::place), by colour, width and
// thickness along its height or its long axis. Both sides of the border must look clearly different;
// otherwise the object counts as one part. `parts` are those of the class, in its order; they get boxes if
// the object is divided. Deterministic.
LooksDivision divide_by_looks(std::span<const ObjectPart> usual, const SurfaceKernels& kernels,
                              MaterialParts& parts);

}  // namespace livegs
