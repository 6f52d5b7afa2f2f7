// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// A longitudinal pulse in a thin, free, undamped bar of 2.4 x 0.1 x 0.1 m at nu 0, where plane waves travel
// at sqrt(E / rho): a bump of velocity in the middle parts into two halves. Timed between two stations by the
// time of largest velocity. "speed" over sqrt(E / rho) (bar 10 %), "height" of the pulse at the far station
// over half the bump's (reference 1; reported, bar 1). The pulse is 0.4 m wide at its foot: 16 cells of 25
// mm.
Result<Outcome> pulse(const Setup& setup);

}  // namespace livegs::study
