// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 27. A block of 0.2 x 0.1 x 0.1 m whose whole boundary is stretched, keeping its volume, to twice its
// yield strain, held, and let go: return mapping leaves a set that knows neither substeps nor the rate of
// loading, close to strain minus yield. `speed` 1 loads over 40 periods of the axial mode, 10 over four.
// LIVE-GS's p is 0.9: yield at 0.1. "set" against set_of_stretch (bar 2 %), "volume_ratio" after release
// (plastic flow keeps volume; bar 1e-3, absolute).
Result<Outcome> plastic_set(const Setup& setup, double speed = 1.0);

// The plastic stretch d, less 1, that is left by a stretch l along one axis with 1/sqrt(l) across: what flow
// keeps of the strain is the radius r of the yield surface (plastic_flow.h),
//   sqrt(2/3) [ (l - d) + (1/sqrt(d) - 1/sqrt(l)) ] = r.
// In simple tension, where the strain across is -nu times the one along, that is l - d = y.
double set_of_stretch(double stretch, double yield, double poisson_ratio);

// The same with the boundary moved as that of a bar in simple tension, whose sides are free: across by the
// width at which such a bar is in balance. What stays is strain minus yield, `yield` (bar 2 %; exact at nu
// 0).
Result<Outcome> plastic_set_in_tension(const Setup& setup, double speed, double yield);

}  // namespace livegs::study
