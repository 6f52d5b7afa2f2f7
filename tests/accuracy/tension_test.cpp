// SPDX-License-Identifier: Apache-2.0
// Scene 20: measured Young's modulus and Poisson's ratio of a bar compared with the requested ones, by the
// closed form of the material under uniaxial stress (uniaxial.h). Tolerances: 5 % and 0.02 for every setting
// that the program calls exact; otherwise the stated band, and 10 % around the ceiling of a clipped setting.
#include "study/elastic_scenes/tension.h"

#include <limits>
#include <map>
#include <vector>

#include "accuracy/scene_checks.h"

namespace livegs::study {
namespace {

// Checks the stated accuracy: exact, a band plus 1 % for the measurement, or a ceiling within 10 %. A body
// that chooses its own settings has a single ceiling; with given cells and substeps, the ceiling has a range.
void expect_as_described(const study::Setup& setup, const Outcome& outcome) {
  const ElasticAccuracy& accuracy = outcome.accuracy;
  const double modulus = outcome["youngs_modulus"].measured;
  if (accuracy.band == ElasticBand::Exact) {
    EXPECT_NEAR(modulus, 1.0, 0.05) << text_of(setup, outcome);
    EXPECT_LE(outcome["poisson_ratio"].error, 0.02) << text_of(setup, outcome);
  } else {
    const double slack = accuracy.band == ElasticBand::Band ? 0.01 : 0.1;
    EXPECT_GT(modulus, accuracy.modulus_ratio_low * (1.0 - slack)) << text_of(setup, outcome);
    EXPECT_LT(modulus, accuracy.modulus_ratio_high * (1.0 + slack)) << text_of(setup, outcome);
  }
}

class Tension : public testing::TestWithParam<std::tuple<double, double>> {};

TEST_P(Tension, MatchesTheStatedAccuracy) {
  const auto [youngs_modulus_pa, poisson_ratio] = GetParam();
  std::vector<study::Setup> setups;
  for (const double rate_hz : kRates_hz) {
    setups.push_back(chosen(youngs_modulus_pa, poisson_ratio, rate_hz));         // own cells and substeps
    setups.push_back(chosen(youngs_modulus_pa, poisson_ratio, rate_hz, 0.025));  // own substeps
    for (const double width_m : gate_or_full<double>({0.025, 0.1}, {0.025, 0.05, 0.1})) {
      for (const int substeps : gate_or_full<int>({1, 4, 16}, {1, 2, 4, 8, 16, 32, 64})) {
        setups.push_back(setup_of(youngs_modulus_pa, poisson_ratio, rate_hz, substeps, width_m));
      }
    }
    // Particle spacings smaller and larger than the default 25 mm.
    for (const double spacing_m : {0.0125, 0.05}) {
      std::vector<study::Setup> spaced = {chosen(youngs_modulus_pa, poisson_ratio, rate_hz),
                                          chosen(youngs_modulus_pa, poisson_ratio, rate_hz, 0.05)};
      for (const int substeps : gate_or_full<int>({4, 16}, {4, 16, 64})) {
        spaced.push_back(setup_of(youngs_modulus_pa, poisson_ratio, rate_hz, substeps, 0.05));
      }
      for (study::Setup& setup : spaced) {
        setup.spacing_m = spacing_m;
        setups.push_back(setup);
      }
    }
  }
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  std::map<double, int> exact_of_spacing;
  for (const study::Setup& setup : setups) {
    const Outcome outcome = run(tension(setup));
    const ElasticAccuracy& accuracy = outcome.accuracy;
    const double modulus = outcome["youngs_modulus"].measured;
    expect_as_described(setup, outcome);
    if (accuracy.band == ElasticBand::Exact) {
      ++exact_of_spacing[setup.spacing_m];
      least = std::min(least, modulus);
      most = std::max(most, modulus);
    }
    if (accuracy.clipped && setup.cells.choose) {
      const double shown_pa = modulus * youngs_modulus_pa;
      EXPECT_NEAR(shown_pa / accuracy.reached_youngs_modulus_pa, 1.0, 0.1) << text_of(setup, outcome);
    }
  }
  // Settings that are called exact differ by at most 5 %, over substeps, cells, rates and particle spacings.
  if (youngs_modulus_pa > 1e7) {
    EXPECT_TRUE(exact_of_spacing.empty());
    return;
  }
  for (const double spacing_m : {0.0125, 0.025, 0.05})
    EXPECT_GE(exact_of_spacing[spacing_m], full_sets() ? 4 : 1) << spacing_m;
  EXPECT_LE(most / least - 1.0, 0.05) << least << " to " << most;
}
INSTANTIATE_TEST_SUITE_P(
    Cells, Tension,
    testing::Combine(testing::ValuesIn(gate_or_full<double>({1e4, 1e6, 1e8}, {1e4, 1e5, 1e6, 1e8})),
                     testing::ValuesIn(gate_or_full<double>({0.0, 0.45}, {0.0, 0.3, 0.45}))),
    [](const auto& tested) {
      char name[64];  // "E10000Pa_nu30"
      std::snprintf(name, sizeof name, "E%.0fPa_nu%.0f", std::get<0>(tested.param),
                    100 * std::get<1>(tested.param));
      return std::string(name);
    });

// Blocks and cubes of few cells, given and chosen. Loads act on nodes that belong to a single cell.
class TensionOfBlocks : public testing::TestWithParam<std::tuple<int, int>> {};

TEST_P(TensionOfBlocks, MatchesTheStatedAccuracy) {
  const auto [along, across] = GetParam();
  const double longest_m = 0.1, width_m = longest_m / std::max(along, across);
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  int exact = 0;
  for (const double youngs_modulus_pa : gate_or_full<double>({1e4, 1e6}, {1e4, 1e5, 1e6})) {
    for (const double poisson_ratio : gate_or_full<double>({0.3}, {0.0, 0.3, 0.45})) {
      for (const double rate_hz : kRates_hz) {
        std::vector<study::Setup> setups = {chosen(youngs_modulus_pa, poisson_ratio, rate_hz, width_m)};
        for (const int substeps : gate_or_full<int>({1, 4, 16}, {1, 2, 4, 8, 16})) {
          setups.push_back(setup_of(youngs_modulus_pa, poisson_ratio, rate_hz, substeps, width_m));
        }
        for (study::Setup& setup : setups) {
          setup.spacing_m = 0.5 * width_m;
          const Outcome outcome = run(tension_of_block(setup, along * width_m, across * width_m));
          const ElasticAccuracy& accuracy = outcome.accuracy;
          const double modulus = outcome["youngs_modulus"].measured;
          if (accuracy.band == ElasticBand::Unknown) {
            EXPECT_FALSE(setup.cells.choose) << text_of(setup, outcome);
          } else {
            expect_as_described(setup, outcome);
          }
          if (accuracy.band == ElasticBand::Exact) {
            ++exact;
            least = std::min(least, modulus);
            most = std::max(most, modulus);
          }
          if (accuracy.clipped) {
            EXPECT_NEAR(modulus * youngs_modulus_pa / accuracy.reached_youngs_modulus_pa, 1.0, 0.1)
                << text_of(setup, outcome);
          }
        }
      }
    }
  }
  EXPECT_GE(exact, full_sets() ? 10 * static_cast<int>(kRates_hz.size()) : 1);  // of 54 per rate
  EXPECT_LE(most / least - 1.0, 0.05) << least << " to " << most;
}
INSTANTIATE_TEST_SUITE_P(
    Cells, TensionOfBlocks,
    testing::ValuesIn(gate_or_full<std::tuple<int, int>>(
        {{1, 1}, {2, 1}, {3, 3}, {8, 4}},
        {{1, 1}, {2, 1}, {2, 2}, {3, 1}, {3, 3}, {4, 2}, {4, 4}, {6, 2}, {6, 6}, {8, 4}})),
    [](const auto& tested) {
      return std::to_string(std::get<0>(tested.param)) + "Along" + std::to_string(std::get<1>(tested.param)) +
             "Across";
    });

// The exact range is not empty: it includes 1e4 to 1e6 Pa with chosen cells and substeps.
TEST(TensionChosen, IsExactUpToAMegapascal) {
  for (const double rate_hz : kRates_hz) {
    for (const double youngs_modulus_pa : {1e4, 1e5, 1e6}) {
      const study::Setup setup = chosen(youngs_modulus_pa, 0.3, rate_hz);
      const Outcome outcome = run(tension(setup));
      EXPECT_EQ(outcome.accuracy.band, ElasticBand::Exact) << text_of(setup, outcome);
    }
  }
}

}  // namespace
}  // namespace livegs::study
