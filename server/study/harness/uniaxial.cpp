// SPDX-License-Identifier: GPL-3.0-or-later
#include "study/harness/uniaxial.h"

namespace livegs::study {

Uniaxial stretched_to(double poisson_ratio, double along) {
  // In units of E. Newton's method from s = 1; the transverse stress is monotonic in s over the whole range.
  const double mu = 0.5 / (1 + poisson_ratio);
  const double lambda = poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
  double s = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double stress = 2 * mu * (s - 1) + lambda * (s * s * along - 1) * s * along;
    const double slope = 2 * mu + lambda * (3 * s * s * along - 1) * along;
    s -= stress / slope;
  }
  return {along, s};
}

Uniaxial stretched_by(double youngs_modulus_pa, double poisson_ratio, double stress_pa) {
  const double mu = 0.5 / (1 + poisson_ratio);
  const double lambda = poisson_ratio / ((1 + poisson_ratio) * (1 - 2 * poisson_ratio));
  const double wanted = stress_pa / youngs_modulus_pa;
  Uniaxial state = stretched_to(poisson_ratio, 1.0);
  // The slope of the axial stress is E at small strain and stays near it: each fixed-point iteration halves
  // the error.
  for (int i = 0; i < 200; ++i) {
    const double s2 = state.across * state.across;
    const double stress = 2 * mu * (state.along - 1) + lambda * (s2 * state.along - 1) * s2;
    state = stretched_to(poisson_ratio, state.along + 0.7 * (wanted - stress));
  }
  return state;
}

}  // namespace livegs::study
