// SPDX-License-Identifier: Apache-2.0
// Sessions over time, with a simulated clock.
#include "session/sessions/session_table.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <condition_variable>
#include <thread>

#include "core/clock.h"
#include "core/log.h"

namespace livegs {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;

class Forgotten final : public InputSink {
 public:
  void on_input(SessionNumber, std::span<const InputSample>) override {}
  void on_session_closed(SessionNumber session) override { sessions.push_back(session); }
  std::vector<SessionNumber> sessions;
};

class Writer final : public SessionWriter {
 public:
  void wake() override {}
  void send_keepalive(int64_t) override { ++beats; }
  void close(const std::string&) override {}
  void end(const Error& why) override { ended = why.message; }
  void end_without_session() override { ++overdue; }
  void abort() override { aborted = true; }
  std::string ended;
  int beats = 0, overdue = 0;
  bool aborted = false;
};

// Blocks in on_input() until a session is closed, or until a timeout.
class SlowListener final : public InputSink {
 public:
  void on_input(SessionNumber session, std::span<const InputSample>) override {
    std::unique_lock lock(mutex_);
    receiving_ = true;
    changed_.notify_all();
    changed_.wait_for(lock, std::chrono::milliseconds(50), [&] { return forgotten_ == session; });
    if (forgotten_ == session) ++received_after;
    receiving_ = false;
  }
  void on_session_closed(SessionNumber session) override {
    std::lock_guard lock(mutex_);
    forgotten_ = session;
    changed_.notify_all();
  }
  void wait_receiving() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return receiving_; });
  }
  int received_after = 0;

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  SessionNumber forgotten_ = 0;
  bool receiving_ = false;
};

// Counts inputs of sessions after they were closed.
class Attentive final : public InputSink {
 public:
  void on_input(SessionNumber session, std::span<const InputSample>) override {
    std::lock_guard lock(mutex_);
    ++received;
    if (gone_.contains(session)) ++received_after;
  }
  void on_session_closed(SessionNumber session) override {
    std::lock_guard lock(mutex_);
    if (!gone_.insert(session).second) ++forgotten_again;
  }
  size_t forgotten() {
    std::lock_guard lock(mutex_);
    return gone_.size();
  }
  int received_after = 0, forgotten_again = 0;
  size_t received = 0;

 private:
  std::mutex mutex_;
  std::set<SessionNumber> gone_;
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

TEST_F(SessionTableTest, SilentStreamAndSessionTimeOut) {
  const auto session = join();
  const auto writer = std::make_shared<Writer>();
  ASSERT_TRUE(session->attach(writer));
  const int64_t last_message_ns = session->last_message_ns;
  table.sweep(last_message_ns + 2 * kSecond_ns - 1);
  EXPECT_FALSE(writer->aborted);
  EXPECT_EQ(writer->beats, 1);
  // The publisher sweeps at least every 0.1 s, so before 2.5 s.
  table.sweep(last_message_ns + 2 * kSecond_ns);
  EXPECT_TRUE(writer->aborted);
  EXPECT_EQ(session->state(), ClientSession::State::Parked);
  table.sweep(last_message_ns + 30 * kSecond_ns - 1);
  EXPECT_EQ(table.find(session->id), session);
  EXPECT_TRUE(inputs.sessions.empty());
  table.sweep(last_message_ns + 30 * kSecond_ns);
  EXPECT_EQ(table.find(session->id), nullptr);
  EXPECT_EQ(inputs.sessions, std::vector<SessionNumber>{session->number});
}

// Each stream is ended once; one that has a session by then is not.
TEST_F(SessionTableTest, StreamWithoutSessionEndsAfterTwoSeconds) {
  const auto first = std::make_shared<Writer>(), second = std::make_shared<Writer>();
  const int64_t before_ns = now_ns();
  table.stream_begun(first);
  table.stream_begun(std::make_shared<Writer>());  // destroyed at once
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

TEST_F(SessionTableTest, AllowsTwoMinutesToLoadAssets) {
  const auto session = join();
  table.sweep(session->last_message_ns + 120 * kSecond_ns - 1);
  EXPECT_EQ(table.find(session->id), session);
  table.sweep(session->last_message_ns + 120 * kSecond_ns);
  EXPECT_EQ(table.find(session->id), nullptr);
}

// A parked session may resume at any time, but no client is refused because of it.
TEST_F(SessionTableTest, LongestParkedSessionMakesRoom) {
  std::vector<std::shared_ptr<ClientSession>> sessions;
  for (size_t i = 0; i < kDefaultSessions; ++i) sessions.push_back(join());
  EXPECT_EQ(join(), nullptr);
  for (const size_t parked : {5u, 3u}) {
    ASSERT_TRUE(sessions[parked]->attach(std::make_shared<Writer>()));
    table.stream_ended(*sessions[parked], 1, false);
  }
  sessions[3]->last_message_ns = sessions[5]->last_message_ns - kSecond_ns;
  EXPECT_NE(join(), nullptr);
  EXPECT_EQ(table.find(sessions[3]->id), nullptr);
  EXPECT_EQ(table.find(sessions[5]->id), sessions[5]);
  EXPECT_EQ(join(sessions[5]->id), sessions[5]);  // an existing session
  EXPECT_EQ(join(), nullptr);
}

TEST_F(SessionTableTest, IgnoresMessagesOfAReplacedStream) {
  const auto session = join();
  const auto first = std::make_shared<Writer>(), second = std::make_shared<Writer>();
  const auto one = session->attach(first);
  ASSERT_TRUE(one);
  EXPECT_EQ(join(session->id), session);
  EXPECT_TRUE(first->aborted);
  const auto two = session->attach(second);
  ASSERT_TRUE(two);
  session->offer(std::make_shared<TickEncodings>(DriverFrame{}, nullptr));
  EXPECT_FALSE(session->take(one->stream, 0));
  EXPECT_FALSE(session->acknowledge(one->stream, 0, 0));
  table.stream_ended(*session, one->stream, true);  // the end of the first stream does not end the session
  EXPECT_EQ(session->state(), ClientSession::State::Streaming);
  EXPECT_TRUE(session->acknowledge(two->stream, 0, 0));
  EXPECT_TRUE(session->take(two->stream, 0));
  table.stream_ended(*session, two->stream, true);
  EXPECT_EQ(table.find(session->id), nullptr);
}

// Join options apply to the session at once: a stream has the options of its own join and no tick of another
// encoding.
TEST_F(SessionTableTest, StreamUsesTheTermsOfItsJoin) {
  const auto tick = std::make_shared<TickEncodings>(DriverFrame{}, nullptr);
  JoinTerms terms;
  terms.encoding = v1::JoinRequest::KERNELS;
  terms.position_bits = 18;
  const auto session = table.join({}, {}, terms)->session;
  session->offer(tick);
  auto stream = session->attach(std::make_shared<Writer>());
  ASSERT_TRUE(stream);
  EXPECT_EQ(stream->terms.encoding, v1::JoinRequest::KERNELS);
  EXPECT_EQ(stream->terms.position_bits, 18);
  EXPECT_FALSE(session->take(stream->stream, 0));  // it was a driver frame
  session->offer(tick, v1::JoinRequest::KERNELS_EXACT);
  EXPECT_FALSE(session->take(stream->stream, 0));
  session->offer(tick, v1::JoinRequest::KERNELS);
  ASSERT_EQ(table.join(session->id)->session, session);  // as drivers; the pending kernels are discarded
  stream = session->attach(std::make_shared<Writer>());
  ASSERT_TRUE(stream);
  EXPECT_EQ(stream->terms.encoding, v1::JoinRequest::DRIVERS);
  EXPECT_FALSE(session->take(stream->stream, 0));
  session->offer(tick, v1::JoinRequest::KERNELS);
  EXPECT_FALSE(session->take(stream->stream, 0));
  session->offer(tick);
  EXPECT_TRUE(session->take(stream->stream, 0));
}

// Input after on_session_closed() would create state in the simulation that is never removed.
TEST(SessionTable, NoInputAfterASessionIsClosed) {
  SlowListener inputs;
  SessionTable table;
  table.open("scene", 90, {}, inputs);
  const auto session = table.join()->session;
  std::thread speaker([&] { table.on_input(*session, {}); });
  inputs.wait_receiving();
  EXPECT_TRUE(table.end_session(session->id, invalid_argument("enough")));
  speaker.join();
  EXPECT_EQ(inputs.received_after, 0);
  table.on_input(*session, {});
  EXPECT_EQ(inputs.received_after, 0);
}

// Two clients send, rejoin, are kicked, revoked and swept while the server closes. Each session is closed
// once, without later input. Under thread sanitizer this also checks for races.
TEST(SessionTable, ClosesEachSessionOnceUnderConcurrency) {
  set_log_level(LogLevel::Warn);
  Attentive inputs;
  SessionTable table;
  table.check_authorizations_with([](const Authorization& authorization) -> Result<void> {
    if (authorization.token_id.size() % 2 == 1) return invalid_argument("it was revoked");
    return {};
  });
  table.open("scene", 90, {}, inputs);
  std::atomic<bool> over{false};
  std::atomic<size_t> joins{0};
  const auto client = [&] {
    std::string last;
    for (size_t turn = 0; !over; ++turn) {
      ClientIdentity who;
      who.authorization.token_id = turn % 3 == 0 ? "odd" : "even";
      const auto joined = table.join(last, who);
      if (!joined) return;  // the table is closed
      ++joins;
      ClientSession& session = *joined->session;
      last = session.id;
      const auto writer = std::make_shared<Writer>();
      const auto stream = session.attach(writer);
      for (int words = 0; words < 100 && table.find(last) && !over; ++words) table.on_input(session, {});
      for (int late = 0; late < 3; ++late) table.on_input(session, {});
      if (stream) table.stream_ended(session, stream->stream, turn % 2 == 0);
    }
  };
  std::array<std::thread, 2> clients{std::thread(client), std::thread(client)};
  while (joins == 0) std::this_thread::yield();
  for (size_t turn = 0; joins < 400; ++turn) {
    for (const auto& session : table.sessions_now())
      (void)table.end_session(session->id, invalid_argument("enough"));
    if (turn % 2 == 0) table.end_unauthorised();
    table.sweep(now_ns());
  }
  table.close("the test is over");
  over = true;
  for (std::thread& one : clients) one.join();
  for (const auto& session : table.sessions_now())
    (void)table.end_session(session->id, invalid_argument("enough"));
  EXPECT_GT(inputs.received, 400u);
  EXPECT_EQ(inputs.received_after, 0);
  EXPECT_EQ(inputs.forgotten_again, 0);
  EXPECT_EQ(inputs.forgotten(), table.totals().sessions);
  set_log_level(LogLevel::Info);
}

TEST_F(SessionTableTest, ParkedSessionCollectsNoEvents) {
  const auto session = join();
  ASSERT_TRUE(session->attach(std::make_shared<Writer>()));
  table.stream_ended(*session, 1, false);
  v1::SessionEvent event;
  event.set_draining("never");
  for (int i = 0; i < 5000; ++i) EXPECT_TRUE(session->add_event(event));
  session->offer(std::make_shared<TickEncodings>(DriverFrame{}, nullptr));
  EXPECT_EQ(join(session->id), session);
  const auto stream = session->attach(std::make_shared<Writer>());
  ASSERT_TRUE(stream);
  EXPECT_FALSE(session->take(stream->stream, 0));
}

}  // namespace
}  // namespace livegs
