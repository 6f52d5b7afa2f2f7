// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// A longitudinal pulse in a thin, free, undamped bar of 2.4 x 0.1 x 0.1 m at nu 0, where plane waves travel
// at sqrt(E / rho). A velocity pulse in the middle splits into two halves; its peak is timed between two
// stations. "speed": relative to sqrt(E / rho) (bar 10 %). "height": at the far station relative to half the
// initial height (reference 1; reported only, bar 1). The pulse is 0.4 m wide at its foot: 16 cells of 25 mm.
Result<Outcome> pulse(const Setup& setup);

}  // namespace livegs::study
