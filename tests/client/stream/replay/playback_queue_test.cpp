// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <thread>

#include "stream/replay/playback_queue.h"

namespace livegs {
namespace {

// Slightly more than `size` thousand bytes of drivers.
ReceivedFrame frame(uint64_t tick, size_t size) {
  ReceivedFrame made;
  made.tick = tick;
  DriverFrame drivers;
  drivers.objects.emplace_back().positions_m.resize(size * 1000 / sizeof(Eigen::Vector3f));
  made.drivers = std::make_shared<const DriverFrame>(std::move(drivers));
  return made;
}

TEST(PlaybackQueue, KeepsTheOrderOfFramesAndEvents) {
  PlaybackQueue queue(1000'000);
  queue.add(frame(1, 10));
  queue.add(ObjectRemoved{7});
  queue.add(frame(2, 10));
  queue.close();
  EXPECT_EQ(std::get<ReceivedFrame>(*queue.take()).tick, 1u);
  EXPECT_EQ(std::get<ObjectRemoved>(*queue.take()).object_id, 7u);
  EXPECT_EQ(std::get<ReceivedFrame>(*queue.take()).tick, 2u);
  EXPECT_FALSE(queue.take());
}

TEST(PlaybackQueue, DropsTheOldestFramesButNoEvent) {
  PlaybackQueue queue(100'000);
  queue.add(ObjectRemoved{1});
  for (uint64_t tick = 1; tick <= 50; ++tick) {
    queue.add(frame(tick, 30));
    queue.add(ObjectRemoved{static_cast<uint32_t>(tick) + 1});
  }
  queue.close();
  EXPECT_EQ(queue.dropped_frames(), 47u);
  uint32_t next_event = 1;
  std::vector<uint64_t> ticks;
  while (const auto item = queue.take()) {
    if (const auto* removed = std::get_if<ObjectRemoved>(&*item)) {
      EXPECT_EQ(removed->object_id, next_event++);
    } else {
      ticks.push_back(std::get<ReceivedFrame>(*item).tick);
    }
  }
  EXPECT_EQ(next_event, 52u);
  EXPECT_EQ(ticks, (std::vector<uint64_t>{48, 49, 50}));
}

TEST(PlaybackQueue, WakesWaitingThread) {
  PlaybackQueue queue(1000'000);
  std::vector<uint64_t> taken;
  std::thread reader([&] {
    while (const auto item = queue.take()) taken.push_back(std::get<ReceivedFrame>(*item).tick);
  });
  for (uint64_t tick = 1; tick <= 100; ++tick) queue.add(frame(tick, 1));
  queue.close();
  reader.join();
  EXPECT_EQ(taken.size(), 100u);
  queue.add(frame(101, 1));  // ignored after close()
  EXPECT_FALSE(queue.take());
}

TEST(PlaybackQueue, ReturnsNothingAfterAbandon) {
  PlaybackQueue queue(1000'000);
  for (uint64_t tick = 1; tick <= 10; ++tick) queue.add(frame(tick, 1));
  queue.close();
  EXPECT_TRUE(queue.take());
  queue.abandon();
  EXPECT_FALSE(queue.take());
}

}  // namespace
}  // namespace livegs
