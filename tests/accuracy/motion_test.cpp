// SPDX-License-Identifier: Apache-2.0
// Scenes 8 and 23 and the pulse in a thin bar, all undamped. References: the axial mode and the wave speed of
// a bar at nu 0, sqrt(E / rho); the physical pendulum.
#include <cmath>

#include "accuracy/scene_checks.h"
#include "known_gaps.h"
#include "study/elastic_scenes/pendulum.h"
#include "study/elastic_scenes/ring_down.h"
#include "study/harness/pulse.h"

namespace livegs::study {
namespace {

TEST(RingDown, KeepsFrequencyAndAmplitudeAtTheChosenSubsteps) {
  // Bars: 1 % of the frequency, 0.9 of the amplitude after five periods, and never a gain.
  for (const double rate_hz : kRates_hz) {
    for (const study::Setup& setup : {chosen(1e4, 0.0, rate_hz, 0.025), chosen(1e5, 0.0, rate_hz, 0.025)}) {
      const Outcome outcome = run(ring_down(setup));
      expect_within_bar(outcome, "frequency", setup);
      expect_within_bar(outcome, "amplitude", setup);
      EXPECT_LE(outcome["amplitude"].measured, 1.01) << text_of(setup, outcome);
    }
  }
}

TEST(RingDown, LossWithTwoCellsIsSmall) {
  // Bars as above. Eight cells of 50 mm along the bar have a dispersion of (pi/8)²/24 = 0.6 %.
  for (const double rate_hz : kRates_hz) {
    for (const study::Setup& setup : {chosen(1e4, 0.0, rate_hz), chosen(1e5, 0.0, rate_hz),
                                      chosen(1e6, 0.0, rate_hz), chosen(1e6, 0.0, rate_hz, 0.05)}) {
      const Outcome outcome = run(ring_down(setup));
      EXPECT_FALSE(outcome.accuracy.clipped);
      report_gap("ring_down.frequency_of_two_cells", outcome["frequency"].error);
      report_gap("ring_down.amplitude_of_two_cells", outcome["amplitude"].measured);
      EXPECT_LE(outcome["amplitude"].measured, 1.01) << text_of(setup, outcome);
    }
  }
}

TEST(Pulse, TravelsAtTheWaveSpeedIfResolved) {
  for (const double rate_hz : kRates_hz) {
    for (const study::Setup& setup :
         {setup_of(1e4, 0.0, rate_hz, 8, 0.025), chosen(1e5, 0.0, rate_hz, 0.025)}) {
      expect_within_bar(run(pulse(setup)), "speed", setup);
    }
  }
}

TEST(Pendulum, KeepsItsEnergy) {
  // Bar: 1 % of the energy in 10 s, from 5 and from 60 degrees.
  for (const double amplitude_rad : {M_PI / 36, M_PI / 3}) {
    for (const double rate_hz : kRates_hz) {
      const study::Setup setup = chosen(1e6, 0.3, rate_hz, 0.05);
      expect_within_bar(run(pendulum(setup, amplitude_rad)), "energy_lost", setup);
    }
  }
}

TEST(Pendulum, PeriodIncludesLumpedMassInertia) {
  // Lattice masses are at the corners of cells, which increases the moment of inertia by m a² / 3. The
  // reference includes this, with a bar of 0.1 %.
  for (const double width_m : {0.025, 0.05}) {
    const study::Setup setup = chosen(1e6, 0.3, 60.0, width_m);
    const Outcome outcome = run(pendulum(setup));
    const Measurement& period = outcome["period"];
    constexpr double length_m = 0.4, edge_m = 0.1, arm_m = 0.2 - edge_m / 6;
    const double inertia_m2 = (length_m * length_m + edge_m * edge_m) / 12 + arm_m * arm_m;
    const double longer = std::sqrt(1 + width_m * width_m / 3 / inertia_m2);
    EXPECT_NEAR(period.measured / (period.reference * longer), 1.0, 1e-3) << text_of(setup, outcome);
  }
}

}  // namespace
}  // namespace livegs::study
