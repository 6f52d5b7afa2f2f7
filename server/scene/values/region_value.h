// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "physics/body_region.h"

namespace livegs {

// Converts a region of a scene file. Sides of the box that are not given are at ±kMaxCoordinate. All numbers
// are bounded. Contradictory or ineffective regions are refused. `field` names the region in errors:
// "objects[0].regions[2]".
Result<BodyRegion> region_value(const v1::Region& region, const std::string& field);

}  // namespace livegs
