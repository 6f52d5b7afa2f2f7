// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace livegs {

// How long a body must be in a state before it counts: still, stuck or tangled.
inline constexpr double kLastingTime_s = 0.5;

}  // namespace livegs
