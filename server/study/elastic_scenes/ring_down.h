// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 23. A free, undamped bar is released from 0.5 % stretch. Its lowest axial mode has f = sqrt(E / rho)
// / (2 L), exact at nu 0. "frequency" (bar 1 %). "amplitude": after five periods relative to the start
// (reference 1, bar 0.1).
Result<Outcome> ring_down(const Setup& setup);

}  // namespace livegs::study
