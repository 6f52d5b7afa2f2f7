// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 22. A free, damped bar under opposite torques at its ends. "twist": of its middle half relative to
// Saint-Venant's, phi = T L / (0.1406 a^4 G) for a square of edge a; bar 8 % at 4 layers, 4 % at 8.
Result<Outcome> torsion(const Setup& setup);

// The same bar twisted by four full turns between its ends, then released. "rest_shape": root mean square
// distance from the rest shape relative to the length; bar 1e-3.
Result<Outcome> torsion_release(const Setup& setup);

}  // namespace livegs::study
