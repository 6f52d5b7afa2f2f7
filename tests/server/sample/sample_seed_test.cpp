// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/parallel_for.h"
#include "server/sample/specimens.h"

namespace livegs {
namespace {

class SampleSeed : public testing::TestWithParam<Specimen> {};

TEST_P(SampleSeed, DependsOnlyOnTheSeed) {
  set_thread_count(1);
  const GaussianAsset first = GetParam().make(1);
  set_thread_count(3);
  EXPECT_TRUE(same_bits(GetParam().make(1), first));
  const GaussianAsset other = GetParam().make(7);
  set_thread_count(0);
  EXPECT_FALSE(same_bits(other, first));
  expect_small_capture(other);
  expect_invariants(other);
  expect_size(other, GetParam());
}

#ifdef LIVEGS_EVERY_SPECIMEN
const auto kTried = testing::ValuesIn(kSpecimens);
#else
// One parametric and one implicit object represent the others, which share their code. The nightly run tests
// all.
const auto kTried = testing::Values(kSpecimens[0], kSpecimens[4]);
#endif
INSTANTIATE_TEST_SUITE_P(SampleScene, SampleSeed, kTried,
                         [](const auto& specimen) { return std::string(specimen.param.name); });

}  // namespace
}  // namespace livegs
