// SPDX-License-Identifier: Apache-2.0
#include "server/scene/run/determinism.h"

namespace livegs {
namespace {

// Long enough for the cup to fall and break, the stack to be struck and the load to sink in.
TEST(Determinism, ShortRunsAreBitEqualForAnyThreadCount) {
  for (const double rate_hz : kRates_hz) testing::expect_same_bits(static_cast<int>(1.67 * rate_hz), rate_hz);
}

}  // namespace
}  // namespace livegs
