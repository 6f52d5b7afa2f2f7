// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "rates.h"
#include "study/harness/rigid_scenes.h"

// The rigid scenes as tests of LiveGS at the default 4 substeps.

namespace livegs::study {

// The outcome of a supported scene; fails the test otherwise.
inline RigidOutcome run(Result<RigidOutcome> outcome) {
  if (outcome) return std::move(*outcome);
  std::fprintf(stderr, "%s\n", outcome.error().message.c_str());
  std::abort();
}

inline void expect_within(const RigidOutcome& outcome, const std::string& quantity, double bar,
                          const RigidSetup& setup) {
  const Measurement& m = outcome[quantity];
  EXPECT_LE(m.error, bar) << quantity << ": measured " << m.measured << " for reference " << m.reference
                          << " at " << setup.rate_hz << " Hz, " << setup.substeps
                          << " substeps: " << name_of(outcome.end);
}
// Uses the bar of the scene.
inline void expect_within_bar(const RigidOutcome& outcome, const std::string& quantity,
                              const RigidSetup& setup) {
  expect_within(outcome, quantity, outcome[quantity].bar, setup);
}

}  // namespace livegs::study
