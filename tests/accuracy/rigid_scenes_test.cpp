// SPDX-License-Identifier: Apache-2.0
// Scenes 2, 3, 6, 9, 16, 29 and breaking at 4 substeps. Bars are those of the catalogue, references the
// closed forms in study/harness/rigid_scenes.h. Single settings and single bodies are tested with the solver.
#include "accuracy/rigid_checks.h"
#include "known_gaps.h"

namespace livegs::study {
namespace {

TEST(Incline, SlidesAtTheFrictionAngle) {
  for (const double rate_hz : kRates_hz) {
    const RigidSetup setup{.rate_hz = rate_hz};
    const RigidOutcome outcome = run(incline(setup));
    for (const char* quantity : {"threshold", "creep", "acceleration"})
      expect_within_bar(outcome, quantity, setup);
  }
}

TEST(Stopping, MatchesFrictionAndStaysAtRest) {
  for (const double rate_hz : kRates_hz) {
    const RigidSetup setup{.rate_hz = rate_hz};
    const RigidOutcome outcome = run(stopping(setup));
    for (const char* quantity : {"distance", "drift"}) expect_within_bar(outcome, quantity, setup);
  }
}

TEST(RollingBox, MatchesTheClosedFormInEveryDirection) {
  for (const double rate_hz : kRates_hz) {
    const RigidSetup setup{.rate_hz = rate_hz};
    const RigidOutcome outcome = run(rolling_box(setup));
    for (const char* quantity : {"speed", "isotropy"}) expect_within_bar(outcome, quantity, setup);
  }
}

TEST(Tumbling, KeepsEnergyMomentumAndFlipTime) {
  for (const double rate_hz : kRates_hz) {
    const RigidSetup setup{.rate_hz = rate_hz};
    const RigidOutcome outcome = run(tumbling(setup));
    for (const char* quantity : {"energy", "momentum", "flip_time"})
      expect_within_bar(outcome, quantity, setup);
  }
}

// dominoes_reference_test verifies the convergence of the reference.
TEST(Dominoes, FallAtTheConvergedSpeed) {
  for (const double rate_hz : kRates_hz) {
    const RigidSetup setup{.rate_hz = rate_hz};
    expect_within_bar(run(dominoes(setup)), "wave_speed", setup);
  }
}

TEST(BreakHeight, IsTheClosedForm) {
  for (const double rate_hz : kRates_hz) {
    for (const double corner : {0.0, 1.0}) {
      const RigidSetup setup{.rate_hz = rate_hz, .parameter = corner};
      const RigidOutcome outcome = run(break_height(setup));
      if (corner > 0.0) {
        report_gap("breaking.corner_height", outcome["height"].error);
      } else {
        expect_within(outcome, "height", 0.02, setup);
      }
    }
  }
}

TEST(SoftDepth, MatchesTheConvergedDepth) {
  for (const double rate_hz : kRates_hz) {
    for (const double cell_width_m : {0.0, 0.025}) {
      const RigidSetup setup{.rate_hz = rate_hz, .parameter = cell_width_m};
      expect_within_bar(run(soft_depth(setup)), "depth", setup);
    }
  }
}

}  // namespace
}  // namespace livegs::study
