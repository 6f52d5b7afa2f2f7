// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>

#include "server/analysis/estimate/known_objects.h"

namespace livegs {
namespace {

// The figures reached on the 26 objects of shared/data/ycb, from their kernels alone, with the goals of the
// analysis issue beside them. The bars stand a little above what was reached, for changes of the surface.
// tests/bench/mass_harness writes all figures with their intervals; of 26 objects a mean is known to about a
// third, and the table's author knows the set.
struct Bar {
  NameGiven name;
  bool metric;
  double most_mape, least_mnre, least_coverage, most_width;
};

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
  EXPECT_LE(scores.mape.value, bar.most_mape);
  EXPECT_GE(scores.mnre.value, bar.least_mnre);
  EXPECT_GE(scores.coverage.value, bar.least_coverage);
  EXPECT_LE(scores.width.value, bar.most_width);
}

INSTANTIATE_TEST_SUITE_P(
    Figures, KnownMass,
    // goal: MAPE 0.25 and coverage 0.85 to 0.95 with a name, MnRE 0.60 without. Coverage is 1.00, 1.00, 1.00,
    // 0.96 and 0.96: wider than these objects need, and not narrowed for them (server/analysis/README.md). The last figure
    // is the median of high over low; goal: no more than would hold 95 % just so.
    testing::Values(Bar{NameGiven::Label, true, 0.17, 0.85, 0.85, 2.5},  // reached 0.138, 0.869, 2.35; goal 1.85
                    // reached 0.54: cup, chain, pitcher, apple; 0.759; 3.23, goal 2.72
                    Bar{NameGiven::FileName, true, 0.62, 0.74, 0.85, 3.5},
                    Bar{NameGiven::Noun, true, 0.66, 0.67, 0.85, 5.1},      // reached 0.54, 0.703; 4.83, goal 4.28
                    Bar{NameGiven::None, true, 1.6, 0.600, 0.85, 21.5},     // reached 1.31, 0.602; 20.2, goal 19.6
                    Bar{NameGiven::Label, false, 0.38, 0.78, 0.85, 10.0}),  // reached 0.32, 0.80; 9.5, goal 6.3
    [](const auto& given) {
      std::string name = kNameGiven[static_cast<int>(given.param.name)];
      name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
      return name + (given.param.metric ? "Metric" : "GuessedScale");
    });

}  // namespace
}  // namespace livegs
