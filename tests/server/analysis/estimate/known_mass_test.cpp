// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>

#include "known_gaps.h"
#include "server/analysis/estimate/known_objects.h"

namespace livegs {
namespace {

// Mass errors of the 26 objects of shared/data/ycb, from kernels alone. tests/bench/mass_harness writes all
// measures with intervals; a mean over 26 objects is uncertain by about a third. Goals with a name: MAPE at
// most 0.25, MnRE at least 0.60, coverage at least 0.85. Missed goals are listed in tests/known_gaps.csv.
struct Bar {
  NameGiven name;
  bool metric;
  const char* id;
  bool mape;  // MAPE is asserted: the goal of 0.25 is met
};
constexpr double kMaxMape = 0.25, kMinMnre = 0.60, kMinCoverage = 0.85;

class KnownMass : public testing::TestWithParam<Bar> {};

TEST_P(KnownMass, IsEstimatedWithinItsBar) {
  const auto& objects = known_objects(KnownForm::Splats);
  if (objects.empty()) GTEST_SKIP() << "shared data is not here";
  const Bar& bar = GetParam();
  const auto answers = estimate_known(objects, bar.name, bar.metric);
  const MassScores scores = mass_scores(answers);
  std::printf("%s: MAPE %.1f %%, MnRE %.3f, coverage %.0f %%, high over low %.2f, of which %.2f is needed\n",
              kNameGiven[static_cast<int>(bar.name)], 100 * scores.mape.value, scores.mnre.value,
              100 * scores.coverage.value, scores.width.value, scores.width_needed.value);
  if (bar.mape) {
    EXPECT_LE(scores.mape.value, kMaxMape);
  } else if (bar.name != NameGiven::None) {
    report_gap(std::string("known_mass.mape.") + bar.id, scores.mape.value);
  }
  EXPECT_GE(scores.mnre.value, kMinMnre);
  EXPECT_GE(scores.coverage.value, kMinCoverage);
  // Width of the ranges, relative to the width that encloses exactly 95 %.
  report_gap(std::string("known_mass.width.") + bar.id, scores.width.value / scores.width_needed.value);
}

INSTANTIATE_TEST_SUITE_P(Figures, KnownMass,
                         testing::Values(Bar{NameGiven::Label, true, "label", true},
                                         Bar{NameGiven::FileName, true, "file_name", false},
                                         Bar{NameGiven::Noun, true, "noun", false},
                                         Bar{NameGiven::None, true, "none", false},
                                         Bar{NameGiven::Label, false, "guessed_scale", false},
                                         Bar{NameGiven::Noun, false, "noun_guessed_scale", false}),
                         [](const auto& given) {
                           std::string name = kNameGiven[static_cast<int>(given.param.name)];
                           name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
                           return name + (given.param.metric ? "Metric" : "GuessedScale");
                         });

}  // namespace
}  // namespace livegs
