// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 20. A free, damped bar is pulled at both ends by 0.5 % of E until it rests; strains are measured over
// its middle half. "youngs_modulus": E_app / E (reference 1, bar 5 %). "poisson_ratio" (bar 0.02, absolute).
Result<Outcome> tension(const Setup& setup);
// The same for a block along x with a square section, with strains measured between the end faces: the middle
// half of a block of few cells is one or two cells, which have unequal strain. Precondition: edges are
// multiples of the spacing, and the section of the cells.
Result<Outcome> tension_of_block(const Setup& setup, double length_m, double width_m);

}  // namespace livegs::study
