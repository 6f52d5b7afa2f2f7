// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "physics/body_region.h"

namespace livegs {

// A region of a scene file as the physics room takes it. Sides of the box that are left out lie at
// ±kMaxCoordinate. Every number is bounded; what contradicts itself or would do nothing is refused.
// `field` is what an error calls the region: "objects[0].regions[2]".
Result<BodyRegion> region_value(const v1::Region& region, const std::string& field);

}  // namespace livegs
