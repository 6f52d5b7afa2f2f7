// SPDX-License-Identifier: Apache-2.0
// Who is there, against a clock of the test's own.
#include "session/session_table.h"

#include <gtest/gtest.h>

#include "core/clock.h"

namespace livegs {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

class Forgotten final : public InputSink {
 public:
  void hear(SessionNumber, std::span<const InputSample>) override {}
  void forget(SessionNumber session) override { sessions.push_back(session); }
  std::vector<SessionNumber> sessions;
};

class Writer final : public SessionWriter {
 public:
  void wake() override {}
  void beat(int64_t) override { ++beats; }
  void close(const std::string&) override {}
  void end(const Error& why) override { ended = why.message; }
  void end_without_session() override { ++overdue; }
  void abort() override { aborted = true; }
  std::string ended;
  int beats = 0, overdue = 0;
  bool aborted = false;
};

class SessionTableTest : public ::testing::Test {
 protected:
  SessionTableTest() { table.open("scene", 90, {}, inputs); }
  std::shared_ptr<ClientSession> join(std::string_view resumed = {}) {
    auto joined = table.join(resumed);
    return joined ? joined->session : nullptr;
  }
  Forgotten inputs;
  SessionTable table;
};

TEST_F(SessionTableTest, ASilentStreamEndsAfterTwoSecondsAndItsSessionAfterHalfAMinute) {
  const auto session = join();
  const auto writer = std::make_shared<Writer>();
  ASSERT_TRUE(session->attach(writer));
  const int64_t heard_ns = session->heard_ns;
  table.sweep(heard_ns + 2 * kSecond_ns - 1);
  EXPECT_FALSE(writer->aborted);
  EXPECT_EQ(writer->beats, 1);
  table.sweep(heard_ns + 2 * kSecond_ns);  // the publisher sweeps at least every 0.1 s: before 2.5 s in any case
  EXPECT_TRUE(writer->aborted);
  EXPECT_EQ(session->state(), ClientSession::State::Parked);
  table.sweep(heard_ns + 30 * kSecond_ns - 1);
  EXPECT_EQ(table.find(session->id), session);
  EXPECT_TRUE(inputs.sessions.empty());
  table.sweep(heard_ns + 30 * kSecond_ns);
  EXPECT_EQ(table.find(session->id), nullptr);
  EXPECT_EQ(inputs.sessions, std::vector<SessionNumber>{session->number});
}

// Each is told once; one that has its session by then does not take it for itself.
TEST_F(SessionTableTest, AStreamThatBeganIsLookedAtAfterTwoSeconds) {
  const auto first = std::make_shared<Writer>(), second = std::make_shared<Writer>();
  const int64_t before_ns = now_ns();
  table.stream_begun(first);
  table.stream_begun(std::make_shared<Writer>());  // and is gone
  table.sweep(before_ns + 2 * kSecond_ns - 1);
  EXPECT_EQ(first->overdue, 0);
  const int64_t after_ns = now_ns();
  table.stream_begun(second);
  table.sweep(after_ns + 2 * kSecond_ns - 1);
  EXPECT_EQ(first->overdue, 1);
  EXPECT_EQ(second->overdue, 0);
  table.sweep(now_ns() + 2 * kSecond_ns);
  EXPECT_EQ(first->overdue, 1);
  EXPECT_EQ(second->overdue, 1);
  EXPECT_FALSE(second->aborted);
}

TEST_F(SessionTableTest, OneThatLoadsAssetsMayTakeTwoMinutes) {
  const auto session = join();
  table.sweep(session->heard_ns + 120 * kSecond_ns - 1);
  EXPECT_EQ(table.find(session->id), session);
  table.sweep(session->heard_ns + 120 * kSecond_ns);
  EXPECT_EQ(table.find(session->id), nullptr);
}

// A parked session may come back at any moment, but nobody who is there is turned away for it.
TEST_F(SessionTableTest, WhoIsParkedLongestMakesRoom) {
  std::vector<std::shared_ptr<ClientSession>> sessions;
  for (size_t i = 0; i < kUsualSessions; ++i) sessions.push_back(join());
  EXPECT_EQ(join(), nullptr);
  for (const size_t parked : {5u, 3u}) {
    ASSERT_TRUE(sessions[parked]->attach(std::make_shared<Writer>()));
    table.stream_ended(*sessions[parked], 1, false);
  }
  sessions[3]->heard_ns = sessions[5]->heard_ns - kSecond_ns;
  EXPECT_NE(join(), nullptr);
  EXPECT_EQ(table.find(sessions[3]->id), nullptr);
  EXPECT_EQ(table.find(sessions[5]->id), sessions[5]);
  EXPECT_EQ(join(sessions[5]->id), sessions[5]);  // it is one of those that are there
  EXPECT_EQ(join(), nullptr);
}

TEST_F(SessionTableTest, AStreamThatWasLeftSaysNothingMore) {
  const auto session = join();
  const auto first = std::make_shared<Writer>(), second = std::make_shared<Writer>();
  const auto one = session->attach(first);
  ASSERT_TRUE(one);
  EXPECT_EQ(join(session->id), session);
  EXPECT_TRUE(first->aborted);
  const auto two = session->attach(second);
  ASSERT_TRUE(two);
  session->offer(std::make_shared<PublishedTick>(DriverFrame{}, nullptr));
  EXPECT_FALSE(session->take(one->stream, 0));
  EXPECT_FALSE(session->acknowledge(one->stream, 0, 0));
  table.stream_ended(*session, one->stream, true);  // the end of the first is not the session's
  EXPECT_EQ(session->state(), ClientSession::State::Streaming);
  EXPECT_TRUE(session->acknowledge(two->stream, 0, 0));
  EXPECT_TRUE(session->take(two->stream, 0));
  table.stream_ended(*session, two->stream, true);
  EXPECT_EQ(table.find(session->id), nullptr);
}

// What a client asks for is the session's in the moment in which it has joined: a stream has the terms of its own join, and no
// tick that another encoding's would be.
TEST_F(SessionTableTest, AStreamHasTheTermsOfItsOwnJoin) {
  const auto tick = std::make_shared<PublishedTick>(DriverFrame{}, nullptr);
  JoinTerms terms;
  terms.encoding = v1::JoinRequest::KERNELS;
  terms.position_bits = 18;
  const auto session = table.join({}, {}, terms)->session;
  session->offer(tick);
  auto stream = session->attach(std::make_shared<Writer>());
  ASSERT_TRUE(stream);
  EXPECT_EQ(stream->terms.encoding, v1::JoinRequest::KERNELS);
  EXPECT_EQ(stream->terms.position_bits, 18);
  EXPECT_FALSE(session->take(stream->stream, 0));  // it was of drivers
  session->offer(tick, v1::JoinRequest::KERNELS_EXACT);
  EXPECT_FALSE(session->take(stream->stream, 0));
  session->offer(tick, v1::JoinRequest::KERNELS);
  ASSERT_EQ(table.join(session->id)->session, session);  // as drivers; the kernels that waited are nobody's
  stream = session->attach(std::make_shared<Writer>());
  ASSERT_TRUE(stream);
  EXPECT_EQ(stream->terms.encoding, v1::JoinRequest::DRIVERS);
  EXPECT_FALSE(session->take(stream->stream, 0));
  session->offer(tick, v1::JoinRequest::KERNELS);
  EXPECT_FALSE(session->take(stream->stream, 0));
  session->offer(tick);
  EXPECT_TRUE(session->take(stream->stream, 0));
}

TEST_F(SessionTableTest, AParkedSessionGathersNothing) {
  const auto session = join();
  ASSERT_TRUE(session->attach(std::make_shared<Writer>()));
  table.stream_ended(*session, 1, false);
  v1::SessionEvent event;
  event.set_draining("never");
  for (int i = 0; i < 5000; ++i) EXPECT_TRUE(session->add_event(event));
  session->offer(std::make_shared<PublishedTick>(DriverFrame{}, nullptr));
  EXPECT_EQ(join(session->id), session);
  const auto stream = session->attach(std::make_shared<Writer>());
  ASSERT_TRUE(stream);
  EXPECT_FALSE(session->take(stream->stream, 0));
}

}  // namespace
}  // namespace livegs
