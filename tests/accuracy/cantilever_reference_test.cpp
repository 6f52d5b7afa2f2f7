// SPDX-License-Identifier: Apache-2.0
// Computes the references of clamp_stiffening: the same bar on lattices of 4, 8 and 16 layers, at Courant
// numbers so small that only the lattice error remains. The limit is extrapolated from the rate of
// convergence (Aitken); the stress singularity at the clamped edge reduces the rate from the element's 2 to
// about 1.4.
#include <cstdio>

#include "accuracy/scene_checks.h"
#include "study/elastic_scenes/cantilever.h"

namespace livegs::study {
namespace {

TEST(CantileverReference, IsTheLimitOfRefinedLattices) {
  for (const double poisson_ratio : {0.0, 0.3, 0.45}) {
    double found[3];
    for (int i = 0; i < 3; ++i) {
      const study::Setup setup = setup_of(1e4, poisson_ratio, 60.0, 8 << i, 0.025 / (1 << i));
      found[i] = run(cantilever(setup))["deflection"].measured;
    }
    const double falls = (found[1] - found[0]) / (found[2] - found[1]);
    const double limit = found[2] + (found[2] - found[1]) / (falls - 1.0);
    std::printf("nu %.2f: %.4f %.4f %.4f, limit %.4f\n", poisson_ratio, found[0], found[1], found[2], limit);
    // Half of the remaining error at 16 layers.
    EXPECT_NEAR(limit, clamp_stiffening(poisson_ratio), 0.002) << "nu " << poisson_ratio;
  }
}

}  // namespace
}  // namespace livegs::study
