// SPDX-License-Identifier: Apache-2.0
// What the chart says of the other methods, and that it compares like with like.
#include "accuracy/scene_checks.h"
#include "study/elastic_scenes/tension.h"

namespace livegs::study {
namespace {

TEST(LivegsV1, ShowsAStiffnessThatGrowsWithSubsteps) {
  study::Setup setup = setup_of(1e5, 0.3, 60.0, 1, 0.025);
  setup.engine = Engine::LivegsV1;
  const double one = run(tension(setup))["youngs_modulus"].measured;
  setup.substeps = 8;
  const double eight = run(tension(setup))["youngs_modulus"].measured;
  // A blend a substep is a stiffness that goes with the square of the substep rate: 64 times.
  EXPECT_GT(eight / one, 32.0);
  EXPECT_LT(eight / one, 128.0);
}

TEST(Bullet, ShowsTheModulusAskedForInTension) {
  // Linear tetrahedra have uniform strain exactly.
  study::Setup setup = setup_of(1e5, 0.3, 60.0, 4, 0.05);
  setup.engine = Engine::Bullet;
  const Outcome outcome = run(tension(setup));
  EXPECT_NEAR(outcome["youngs_modulus"].measured, 1.0, 0.01);
  EXPECT_NEAR(outcome["poisson_ratio"].measured, 0.3, 0.01);
}

}  // namespace
}  // namespace livegs::study
