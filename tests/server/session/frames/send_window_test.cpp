// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <deque>

#include "session/frames/send_window.h"

namespace livegs {
namespace {

std::shared_ptr<const TickEncodings> tick(uint64_t number) {
  DriverFrame frame;
  frame.tick = number;
  return std::make_shared<TickEncodings>(frame, nullptr);
}

v1::SessionEvent removal(uint32_t id) {
  v1::SessionEvent event;
  event.mutable_object_removed()->set_object_id(id);
  return event;
}

uint64_t taken(SendWindow& window) {
  const auto outgoing = window.take(0);
  return outgoing && outgoing->tick ? outgoing->tick->tick() : 0;
}

TEST(SendWindow, SendsTheNewestWhenTheWindowOpens) {
  SendWindow window;
  for (uint64_t number = 1; number <= 5; ++number) {
    window.offer(tick(number));
    EXPECT_EQ(taken(window), number <= 2 ? number : 0);
  }
  EXPECT_EQ(window.in_flight(), 2u);
  EXPECT_EQ(window.replaced(), 2u);  // 3 and 4
  window.acknowledge(1, 0);
  EXPECT_EQ(taken(window), 5u);
  EXPECT_EQ(taken(window), 0u);
  EXPECT_EQ(window.sent(), 3u);
}

TEST(SendWindow, AcknowledgementCoversEarlierFrames) {
  SendWindow window;
  window.offer(tick(1));
  taken(window);
  window.offer(tick(2));
  taken(window);
  window.acknowledge(2, 0);
  EXPECT_EQ(window.in_flight(), 0u);
}

TEST(SendWindow, IgnoresOldAcknowledgements) {
  SendWindow window;
  window.offer(tick(7));
  taken(window);
  window.acknowledge(3, 0);
  EXPECT_EQ(window.in_flight(), 1u);
}

TEST(SendWindow, FutureAcknowledgementFreesOnlySentFrames) {
  SendWindow window;
  for (uint64_t number = 1; number <= 2; ++number) {
    window.offer(tick(number));
    taken(window);
  }
  window.acknowledge(~uint64_t{0}, 0);
  EXPECT_EQ(window.in_flight(), 0u);
  for (uint64_t number = 3; number <= 6; ++number) {
    window.offer(tick(number));
    taken(window);
  }
  EXPECT_EQ(window.in_flight(), WindowSize::kInitialFrames);
}

// Round trips of 40 ms open the window; a new stream starts with two again.
TEST(SendWindow, GrowsWithTheRoundTrip) {
  constexpr int64_t kTickInterval_ns = 11'111'111;
  SendWindow window;
  std::deque<std::pair<int64_t, uint64_t>> answers;  // time and tick
  for (uint64_t number = 1; number <= 300; ++number) {
    const int64_t tick_ns = static_cast<int64_t>(number) * kTickInterval_ns;
    for (; !answers.empty() && answers.front().first <= tick_ns; answers.pop_front()) {
      window.acknowledge(answers.front().second, answers.front().first);
      if (const auto outgoing = window.take(answers.front().first))
        answers.emplace_back(answers.front().first + 40'000'000, outgoing->tick->tick());
    }
    window.offer(tick(number));
    if (const auto outgoing = window.take(tick_ns))
      answers.emplace_back(tick_ns + 40'000'000, outgoing->tick->tick());
    if (number == 10) {
      EXPECT_EQ(window.size(), 2u);
    }
  }
  EXPECT_EQ(window.size(), 4u);
  EXPECT_EQ(window.in_flight(), 4u);
  window.restart();
  EXPECT_EQ(window.size(), 2u);
}

TEST(SendWindow, SendsEventsInOrderWhenFull) {
  SendWindow window;
  for (uint64_t number = 1; number <= 3; ++number) {
    window.offer(tick(number));
    if (number <= 2) taken(window);
  }
  ASSERT_TRUE(window.add_event(removal(10)));
  ASSERT_TRUE(window.add_event(removal(11)));
  const auto outgoing = window.take(0);
  ASSERT_TRUE(outgoing);
  EXPECT_EQ(outgoing->tick, nullptr);
  ASSERT_EQ(outgoing->events.size(), 2u);
  EXPECT_EQ(outgoing->events[0].object_removed().object_id(), 10u);
  EXPECT_EQ(outgoing->events[1].object_removed().object_id(), 11u);
  EXPECT_FALSE(window.take(0));
}

TEST(SendWindow, RefusesEventsOfAClientThatDoesNotRead) {
  SendWindow window;
  for (size_t i = 0; i < SendWindow::kMaxWaitingEvents; ++i) ASSERT_TRUE(window.add_event(removal(1)));
  EXPECT_FALSE(window.add_event(removal(1)));
}

}  // namespace
}  // namespace livegs
