// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "physics/world.h"

// Validation of descriptions passed to the World. Errors name the object, the field and the range.

namespace livegs {

Result<void> check_settings(const WorldSettings& settings);
// Range of a breakable body's threshold, equal to the range in scene files. Below the minimum, standing would
// count as an impact.
inline constexpr double kMinBreakImpulse_n_s = 1e-6, kMaxBreakImpulse_n_s = 1e6;
Result<void> check_break_impulse(uint32_t object_id, const Material& material);
Result<void> check_rigid(const RigidBodyDescription& description);
Result<void> check_ball(const BallDescription& description);

}  // namespace livegs
