// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "physics/body_region.h"

namespace livegs {

// Reads the motion of a region. Times are simulated seconds from 0 to kMaxTime_s, in increasing order. A
// constant velocity without an end time ends at kMaxTime_s. `field` names the motion in errors.
inline constexpr double kMaxTime_s = 1e6;
Result<RegionMotion> motion_value(const v1::Motion& motion, const std::string& field);

}  // namespace livegs
