// SPDX-License-Identifier: Apache-2.0
// Scenes 21 and 22. References: Timoshenko's beam at nu 0; at nu 0.45, where the clamp prevents the section
// from contracting, the 3-D bar on refined lattices (cantilever.h, cantilever_reference_test.cpp);
// Saint-Venant's torsion.
#include "accuracy/scene_checks.h"
#include "known_gaps.h"
#include "study/elastic_scenes/cantilever.h"
#include "study/elastic_scenes/torsion.h"

namespace livegs::study {
namespace {

TEST(Cantilever, MatchesTimoshenkoAtNuZero) {
  // Bar 3 % at 4 and 8 layers.
  for (const double rate_hz : kRates_hz) {
    for (const study::Setup& setup : {chosen(1e4, 0.0, rate_hz, 0.025), chosen(1e4, 0.0, rate_hz, 0.0125),
                                      chosen(1e5, 0.0, rate_hz, 0.025)}) {
      expect_within_bar(run(cantilever(setup)), "deflection", setup);
    }
  }
}

TEST(Cantilever, MatchesTheConvergedReferenceAtNu045) {
  for (const double rate_hz : kRates_hz) {
    const study::Setup setup = chosen(1e4, 0.45, rate_hz, 0.025);
    expect_within_bar(run(cantilever(setup)), "deflection", setup);
  }
}

TEST(Torsion, MatchesSaintVenant) {
  // Bars: 8 % at 4 layers, 4 % at 8.
  for (const double rate_hz : kRates_hz) {
    for (const study::Setup& setup : {chosen(1e4, 0.0, rate_hz, 0.025), chosen(1e4, 0.3, rate_hz, 0.025),
                                      chosen(1e4, 0.0, rate_hz, 0.0125), chosen(1e4, 0.3, rate_hz, 0.0125),
                                      chosen(1e5, 0.3, rate_hz, 0.025)}) {
      expect_within_bar(run(torsion(setup)), "twist", setup);
    }
  }
}

TEST(Torsion, TwoLayersAreTooStiff) {
  // The chosen cells are half as thick as the bar, and a converged element with two layers is too stiff.
  for (const double rate_hz : kRates_hz) {
    for (const double youngs_modulus_pa : {1e4, 1e5}) {
      const study::Setup setup = chosen(youngs_modulus_pa, 0.3, rate_hz, 0.0);
      const Outcome outcome = run(torsion(setup));
      report_gap("torsion.two_layers", outcome["twist"].error);
    }
  }
}

TEST(Torsion, UnwindsFromFourTurns) {
  const study::Setup setup = setup_of(1e4, 0.3, 60.0, 16, 0.025);
  const Outcome outcome = run(torsion_release(setup));
  expect_within_bar(outcome, "turns", setup);
  expect_within_bar(outcome, "rest_shape", setup);
}

}  // namespace
}  // namespace livegs::study
