// SPDX-License-Identifier: Apache-2.0
#include "server/scene/run/determinism.h"

namespace livegs {
namespace {

// Each long enough for the cup to fall and break, the stack to be struck and the load to sink in.
TEST(Determinism, AHundredAndFiftyTicksOfEverythingAreTheSameBitsForAnyNumberOfThreads) {
  testing::expect_same_bits(150, 90);
  testing::expect_same_bits(100, 60);
}

}  // namespace
}  // namespace livegs
