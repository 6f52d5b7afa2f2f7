// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// A bar of two materials in series, with the part x > joint twice as stiff, pulled at both ends. Both have
// the same stress, so each strain is stress / E. "soft_strain" and "stiff_strain": over the middle half of
// each part, relative to the closed form (bar 10 %). At `joint_m` 0 the parts meet on a plane between cells.
Result<Outcome> two_materials(const Setup& setup, double joint_m = 0.0);

}  // namespace livegs::study
