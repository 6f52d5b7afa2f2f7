// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/result.h"
#include "study/harness/setup.h"

namespace livegs::study {

// Scene 8. An undamped rod of 0.4 x 0.1 x 0.1 m, hinged on a line of particles at one end, swings for 10 s
// from `amplitude_rad`. "period": compared with the physical pendulum, with the exact correction for
// amplitude and the first-order one for stretch and bending under its weight (bar 0.1 %). "energy_lost": of
// the swing (bar 1 %). The spacing is always a third of the rod's width.
Result<Outcome> pendulum(const Setup& setup, double amplitude_rad = 0.08726646);

// Period of a rod of the scene's size, hinged `hinge_m` from its end.
double pendulum_period_s(double hinge_m, double amplitude_rad, double youngs_modulus_pa,
                         double density_kg_m3);

}  // namespace livegs::study
