// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cstdio>

#include "server/analysis/known_objects.h"

namespace livegs {
namespace {

// The figures reached on the 26 objects of shared/data/ycb, from their kernels alone, with the goals of the
// analysis issue beside them. The bars stand a little above what was reached, for changes of the surface.
// tests/bench/mass_harness writes all figures with their intervals; of 26 objects a mean is known to about a
// third, and the table's author knows the set.
struct Bar {
  NameGiven name;
  bool metric;
  double most_mape, least_mnre, least_coverage;
};

class KnownMass : public testing::TestWithParam<Bar> {};

TEST_P(KnownMass, IsEstimatedWithinItsBar) {
  const auto& objects = known_objects(KnownForm::Splats);
  if (objects.empty()) GTEST_SKIP() << "shared data is not here";
  const Bar& bar = GetParam();
  const auto answers = estimate_known(objects, bar.name, bar.metric);
  const MassScores scores = mass_scores(answers);
  std::printf("%s: MAPE %.1f %%, MnRE %.3f, coverage %.0f %%\n", kNameGiven[static_cast<int>(bar.name)],
              100 * scores.mape.value, scores.mnre.value, 100 * scores.coverage.value);
  EXPECT_LE(scores.mape.value, bar.most_mape);
  EXPECT_GE(scores.mnre.value, bar.least_mnre);
  EXPECT_GE(scores.coverage.value, bar.least_coverage);
}

INSTANTIATE_TEST_SUITE_P(
    Figures, KnownMass,
    // goal: MAPE 0.25 and coverage 0.85 to 0.95 with a name, MnRE 0.60 without. Coverage is 1.00, 1.00, 1.00,
    // 0.96 and 0.96: wider than these objects need, and not narrowed for them (server/analysis/README.md).
    testing::Values(Bar{NameGiven::Label, true, 0.13, 0.88, 0.85},  // reached 0.105, 0.90
                    Bar{NameGiven::FileName, true, 0.56, 0.76,
                        0.85},                                     // reached 0.46: cup, chain, pitcher, apple
                    Bar{NameGiven::Noun, true, 0.66, 0.67, 0.85},  // reached 0.54
                    Bar{NameGiven::None, true, 1.6, 0.600, 0.85},  // reached 1.30, 0.604
                    Bar{NameGiven::Label, false, 0.36, 0.79, 0.85}),  // reached 0.30, 0.81
    [](const auto& given) {
      std::string name = kNameGiven[static_cast<int>(given.param.name)];
      name.erase(std::remove(name.begin(), name.end(), ' '), name.end());
      return name + (given.param.metric ? "Metric" : "GuessedScale");
    });

}  // namespace
}  // namespace livegs
