// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 21. A bar of 0.4 x 0.1 x 0.1 m, clamped at one face, sags by 1 % of its length under its own weight.
// "deflection": of the tip relative to Timoshenko's beam (shear coefficient 5/6). Bar 3 % at nu 0; 5 % of the
// converged 3-D reference at nu > 0, where the clamp stiffens the bar (clamp_stiffening).
Result<Outcome> cantilever(const Setup& setup);

// Deflection of the 3-D bar relative to Timoshenko's, extrapolated from refined lattices
// (cantilever_reference_test.cpp); 1 at nu 0. Precondition: nu is 0, 0.3 or 0.45.
double clamp_stiffening(double poisson_ratio);

// Timoshenko: rho g A L^4 / (8 E I) + rho g L^2 / (2 k G), for the weight with a sag of 1 % of the length.
double timoshenko_sag_m(double youngs_modulus_pa, double poisson_ratio, double weight_n_m3);

}  // namespace livegs::study
