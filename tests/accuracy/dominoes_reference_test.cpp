// SPDX-License-Identifier: Apache-2.0
// Compares the reference of the dominoes, LiveGS at 256 substeps and 60 Hz, with 128 substeps at 60 and at 90
// Hz: the difference is within a tenth of the bar.
#include "accuracy/rigid_checks.h"

namespace livegs::study {
namespace {

TEST(Dominoes, ReferenceIsConverged) {
  for (const RigidSetup& setup :
       {RigidSetup{.substeps = 128}, RigidSetup{.rate_hz = 90.0, .substeps = 128}}) {
    expect_within(run(dominoes(setup)), "wave_speed", 0.005, setup);
  }
}

}  // namespace
}  // namespace livegs::study
