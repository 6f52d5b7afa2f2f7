// SPDX-License-Identifier: Apache-2.0
// Scenes 21, 22 and 24: bending, twisting and squashing against closed forms, or a converged reference where a clamp
// makes the closed form wrong. References and their sources stand in the study's headers.
#include <gtest/gtest.h>

#include "study/cantilever.h"
#include "study/squash.h"
#include "study/torsion.h"

namespace livegs::study {
namespace {

Setup bar(double cell_width_m, double poisson_ratio, int substeps) {
  study::Setup setup;
  setup.youngs_modulus_pa = 1e4;
  setup.poisson_ratio = poisson_ratio;
  setup.cell_width_m = cell_width_m;
  setup.spacing_m = std::min(0.025, cell_width_m);
  setup.substeps = substeps;
  return setup;
}

double error_of(const Result<Outcome>& outcome) {
  EXPECT_TRUE(outcome) << outcome.error().message;
  return outcome->measurements[0].error;
}

// Within 3 % of Timoshenko at nu 0; within 5 % of the converged 3-D bar at nu 0.45.
TEST(Cantilever, SagsAsItShouldAtFourAndEightLayers) {
  EXPECT_LT(error_of(cantilever(bar(0.025, 0.0, 4))), 0.03);
  EXPECT_LT(error_of(cantilever(bar(0.0125, 0.0, 8))), 0.03);
  EXPECT_LT(error_of(cantilever(bar(0.025, 0.45, 8))), 0.05);
}

// Saint-Venant: 8 % at 4 layers, 4 % at 8.
TEST(Torsion, TwistsAsItShouldAtFourAndEightLayers) {
  EXPECT_LT(error_of(torsion(bar(0.025, 0.0, 4))), 0.08);
  EXPECT_LT(error_of(torsion(bar(0.0125, 0.0, 8))), 0.04);
}

TEST(Torsion, UnwindsFromFourTurns) { EXPECT_LT(error_of(torsion_release(bar(0.025, 0.3, 8))), 1e-3); }

// 30 % between frictionless plates at nu 0.45: V / V0 0.954 in this energy, 1 %.
TEST(Squash, KeepsTheMaterialsOwnVolume) {
  study::Setup setup = bar(0.025, 0.45, 16);
  EXPECT_LT(error_of(squash(setup)), 0.01);
}

}  // namespace
}  // namespace livegs::study
