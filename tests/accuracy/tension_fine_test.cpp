// SPDX-License-Identifier: Apache-2.0
// Scene 20 at eight layers, which would take too long in tension_test.cpp.
#include <vector>

#include "accuracy/scene_checks.h"
#include "study/elastic_scenes/tension.h"
#include "study/harness/block.h"
#include "study/harness/stage.h"

namespace livegs::study {
namespace {

TEST(TensionFine, HasTheModulusWhereCalledExact) {
  int count = 0;
  for (const double youngs_modulus_pa : {1e4, 1e5, 1e6}) {
    for (const double poisson_ratio : {0.0, 0.3, 0.45}) {
      for (const double rate_hz : kRates_hz) {
        for (const int substeps : {4, 8, 16, 32, 64}) {
          const study::Setup setup = setup_of(youngs_modulus_pa, poisson_ratio, rate_hz, substeps, 0.0125);
          auto stage = Stage::make(setup, describe_bar(setup));
          if (!stage || stage->body().accuracy().band != ElasticBand::Exact) continue;
          const Outcome outcome = run(tension(setup));
          expect_within_bar(outcome, "youngs_modulus", setup);
          expect_within_bar(outcome, "poisson_ratio", setup);
          ++count;
        }
      }
    }
  }
  EXPECT_GE(count, 30);
}

}  // namespace
}  // namespace livegs::study
