// SPDX-License-Identifier: Apache-2.0
#include "server/scene/run/determinism.h"

namespace livegs {
namespace {

// The bar of the project: ten seconds at 60 Hz.
TEST(Determinism, LongRunsAreBitEqualForAnyThreadCount) {
  for (const double rate_hz : kRates_hz) testing::expect_same_bits(600, rate_hz);
}

}  // namespace
}  // namespace livegs
