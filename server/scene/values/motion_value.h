// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "core/result.h"
#include "livegs/v1/scene.pb.h"
#include "physics/body_region.h"

namespace livegs {

// The motion of a region. Times are seconds of simulation from 0 to kMaxTime_s and in order. A constant
// velocity without an end has kMaxTime_s for one. `field` is what an error calls the motion.
inline constexpr double kMaxTime_s = 1e6;
Result<RegionMotion> motion_value(const v1::Motion& motion, const std::string& field);

}  // namespace livegs
