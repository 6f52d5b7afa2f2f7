// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

// A block under stress along one axis and free across it: the closed form for the energy of `cells`,
//   W = mu |S - I|² + lambda/2 (det F - 1)²        (per volume; mu, lambda are Lamé's at small strain),
// with stretches l along and s across. Stresses per rest area:
//   along   2 mu (l - 1) + lambda (s² l - 1) s²
//   across  2 mu (s - 1) + lambda (s² l - 1) s l = 0

namespace livegs::study {

struct Uniaxial {
  double along = 1.0, across = 1.0;
  double volume_ratio() const { return along * across * across; }
};

// Preconditions: stress between -0.3 E and 0.3 E; nu 0 to 0.49.
Uniaxial stretched_by(double youngs_modulus_pa, double poisson_ratio, double stress_pa);
// Precondition: along between 0.5 and 2.
Uniaxial stretched_to(double poisson_ratio, double along);

}  // namespace livegs::study
