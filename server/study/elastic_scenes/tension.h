// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 20. A free bar pulled at both ends by 0.5 % of E, damped, until it rests; strains over its middle
// half. "youngs_modulus" E_app / E (reference 1, bar 5 %), "poisson_ratio" (bar 0.02, absolute).
Result<Outcome> tension(const Setup& setup);
// The same of a block along x with a square section, with strains from face to face: of a few cells along,
// the middle half is one or two, which share the strain unequally. Precondition: edges are multiples of the
// spacing, and the section of the cells.
Result<Outcome> tension_of_block(const Setup& setup, double length_m, double width_m);

}  // namespace livegs::study
