// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 21. A bar of 0.4 x 0.1 x 0.1 m clamped at one face sags under its own weight, by 1 % of its length.
// "deflection" of the tip over Timoshenko's (shear coefficient 5/6); bar 3 % at nu 0, 5 % of the converged
// 3-D reference at nu > 0, where the clamp stiffens: see clamp_stiffening.
Result<Outcome> cantilever(const Setup& setup);

// Deflection of the 3-D bar over Timoshenko's, extrapolated from finer and finer lattices
// (cantilever_reference_test.cpp); 1 at nu 0. Precondition: nu is 0, 0.3 or 0.45.
double clamp_stiffening(double poisson_ratio);

// Timoshenko: rho g A L^4 / (8 E I) + rho g L^2 / (2 k G), for the weight that sags by 1 % of the length.
double timoshenko_sag_m(double youngs_modulus_pa, double poisson_ratio, double weight_n_m3);

}  // namespace livegs::study
