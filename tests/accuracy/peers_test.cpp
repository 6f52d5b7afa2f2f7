// SPDX-License-Identifier: Apache-2.0
// Checks that the chart compares equal settings of the peers.
#include "accuracy/scene_checks.h"
#include "study/elastic_scenes/tension.h"

namespace livegs::study {
namespace {

TEST(Bullet, HasTheRequestedModulusInTension) {
  // Linear tetrahedra represent uniform strain exactly.
  study::Setup setup = setup_of(1e5, 0.3, 60.0, 4, 0.05);
  setup.engine = Engine::Bullet;
  const Outcome outcome = run(tension(setup));
  EXPECT_NEAR(outcome["youngs_modulus"].measured, 1.0, 0.01);
  EXPECT_NEAR(outcome["poisson_ratio"].measured, 0.3, 0.01);
}

}  // namespace
}  // namespace livegs::study
