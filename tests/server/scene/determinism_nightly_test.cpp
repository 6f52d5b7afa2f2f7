// SPDX-License-Identifier: Apache-2.0
#include "server/scene/determinism.h"

namespace livegs {
namespace {

// The bar of the issue.
TEST(Determinism, SixHundredTicksOfEverythingAreTheSameBitsForAnyNumberOfThreads) {
  testing::expect_same_bits(600);
}

}  // namespace
}  // namespace livegs
