// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 27. A block of 0.2 x 0.1 x 0.1 m. Its whole boundary is stretched at constant volume to twice the
// yield strain, held and released. Return mapping leaves a plastic strain that is independent of substeps and
// loading rate, close to strain minus yield. `speed` 1 loads over 40 periods of the axial mode, 10 over four.
// LIVE-GS's p is 0.9: yield at 0.1. "set": compared with set_of_stretch (bar 2 %). "volume_ratio": after
// release (plastic flow keeps the volume; bar 1e-3, absolute).
Result<Outcome> plastic_set(const Setup& setup, double speed = 1.0);

// The plastic stretch d, minus 1, after a stretch l along one axis with 1/sqrt(l) across. The remaining
// elastic strain is the radius r of the yield surface (return_mapping.h):
//   sqrt(2/3) [ (l - d) + (1/sqrt(d) - 1/sqrt(l)) ] = r.
// In simple tension, where the strain across is -nu times the one along, this is l - d = y.
double set_of_stretch(double stretch, double yield, double poisson_ratio);

// The same with the boundary of a bar in simple tension, whose sides are free: across, the boundary has the
// equilibrium width of such a bar. The plastic strain is strain minus yield, `yield` (bar 2 %; exact at nu
// 0).
Result<Outcome> plastic_set_in_tension(const Setup& setup, double speed, double yield);

}  // namespace livegs::study
