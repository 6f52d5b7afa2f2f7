// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/log.h"
#include "rates.h"
#include "study/harness/setup.h"

// The canonical scenes as tests, run through the same interface as in the world. Each bar belongs to a closed
// form or a converged reference.

namespace livegs::study {

// Stiffnesses out of reach are intended here; their warnings would hide failures.
inline const bool kQuietLog = [] {
  set_log_level(LogLevel::Error);
  return true;
}();

// The outcome of a supported scene; fails the test otherwise.
inline Outcome run(Result<Outcome> outcome) {
  if (outcome) return std::move(*outcome);
  std::fprintf(stderr, "%s\n", outcome.error().message.c_str());
  std::abort();
}

inline Setup setup_of(double youngs_modulus_pa, double poisson_ratio, double rate_hz, int substeps,
                      double cell_width_m) {
  Setup setup;
  setup.youngs_modulus_pa = youngs_modulus_pa;
  setup.poisson_ratio = poisson_ratio;
  setup.rate_hz = rate_hz;
  setup.substeps = substeps;
  setup.cell_width_m = cell_width_m;
  setup.spacing_m = cell_width_m > 0.0 ? std::min(0.025, cell_width_m) : 0.025;
  return setup;
}

// The default 4 substeps. The body adds substeps if needed, and chooses its cells if no width is given.
inline Setup chosen(double youngs_modulus_pa, double poisson_ratio, double rate_hz,
                    double cell_width_m = 0.0) {
  Setup setup = setup_of(youngs_modulus_pa, poisson_ratio, rate_hz, 4, cell_width_m);
  setup.cells.choose = true;
  return setup;
}

// Requested settings and the resulting ones.
inline std::string text_of(const Setup& setup, const Outcome& outcome) {
  char text[240];
  std::snprintf(text, sizeof text,
                "E %g Pa, nu %g, %g Hz, %d substeps%s, cells %g m: used %d of %g m, Courant %.2f, band %s,  "
                "%.3f to %.3f",
                setup.youngs_modulus_pa, setup.poisson_ratio, setup.rate_hz, setup.substeps,
                setup.cells.choose ? " or more" : "", setup.cell_width_m, outcome.accuracy.substeps,
                outcome.accuracy.cell_width_m, outcome.accuracy.courant, name_of(outcome.accuracy.band),
                outcome.accuracy.modulus_ratio_low, outcome.accuracy.modulus_ratio_high);
  return text;
}

inline void expect_within_bar(const Outcome& outcome, const std::string& quantity, const Setup& setup) {
  const Measurement& m = outcome[quantity];
  EXPECT_LE(m.error, m.bar) << quantity << ": measured " << m.measured << " for reference " << m.reference
                            << "; " << text_of(setup, outcome);
}

}  // namespace livegs::study
