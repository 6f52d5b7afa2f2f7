// SPDX-License-Identifier: Apache-2.0
#include "session/published_tick.h"

#include <gtest/gtest.h>

namespace livegs {
namespace {

DriverFrame swinging(uint64_t tick) {
  DriverFrame frame;
  frame.tick = tick;
  ObjectDrivers& object = frame.objects.emplace_back();
  object.object_id = 1;
  object.kind = DriverKind::Lattice;
  for (int i = 0; i < 100; ++i) {
    object.positions_m.emplace_back(0.01 * i, 0.1 * std::sin(0.1 * static_cast<double>(tick) + i), 0);
  }
  return frame;
}

// One client misses a frame now and then. It is encoded for by itself until it has what the others have.
TEST(PublishedTick, IsEncodedOnceForClientsThatHaveTheSame) {
  const auto record = std::make_shared<EncodingRecord>();
  StreamBaselinePtr quick, quick_too, slow;
  for (uint64_t tick = 1; tick <= 100; ++tick) {
    const PublishedTick published(swinging(tick), record);
    quick = published.against(quick).next;
    quick_too = published.against(quick_too).next;
    if (tick % 20 != 10) slow = published.against(slow).next;
    EXPECT_EQ(quick, quick_too);
  }
  EXPECT_EQ(quick, slow);
  // A hundred, and three for each of the five that were missed: what is predicted looks back three frames.
  EXPECT_EQ(record->summary().encoded, 115u);
}

}  // namespace
}  // namespace livegs
