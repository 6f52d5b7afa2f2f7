// SPDX-License-Identifier: Apache-2.0
// The dominoes' reference, our own solver at 256 substeps of 60 Hz, against 128 substeps of 60 and of 90 Hz:
// within a tenth of the 5 % that it judges.
#include "accuracy/rigid_checks.h"

namespace livegs::study {
namespace {

TEST(Dominoes, HalfAsFineStepsAreWithinATenthOfTheBar) {
  for (const RigidSetup& setup :
       {RigidSetup{.substeps = 128}, RigidSetup{.rate_hz = 90.0, .substeps = 128}}) {
    expect_within(run(dominoes(setup)), "wave_speed", 0.005, setup);
  }
}

}  // namespace
}  // namespace livegs::study
