// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 24. A 0.1 m block pressed by 30 % between two frictionless plates, damped.
// "volume_ratio" V / V0 against the material's own closed form (uniaxial.h: 0.954 at nu 0.45), bar 1 %.
// Particles of `cells` are half a cell apart, whatever the setup says. Bullet is not connected to plates:
// unsupported.
Result<Outcome> squash(const Setup& setup);

}  // namespace livegs::study
