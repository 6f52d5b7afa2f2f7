// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 24. A damped block of 0.1 m is compressed by 30 % between two frictionless plates. "volume_ratio": V
// / V0 compared with the closed form of the material (uniaxial.h: 0.954 at nu 0.45), bar 1 %. Particles of
// `cells` are always half a cell apart. Bullet is unsupported, because its adapter has no plates.
Result<Outcome> squash(const Setup& setup);

}  // namespace livegs::study
