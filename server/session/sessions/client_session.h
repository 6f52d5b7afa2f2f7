// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "session/access/authorization.h"
#include "session/frames/send_budget.h"
#include "session/frames/send_window.h"
#include "session/support/duration_histogram.h"
#include "session/tick/tick_result.h"

namespace livegs {

// The connection of a session. Any thread.
class SessionWriter {
 public:
  virtual ~SessionWriter() = default;
  virtual void wake() = 0;
  // Writes an empty message if nothing was written for kKeepaliveInterval_ns.
  virtual void send_keepalive(int64_t now_ns) = 0;
  // Writes waiting events, then ends the stream with UNAVAILABLE and `reason`.
  virtual void close(const std::string& reason) = 0;
  // Ends the stream with the error after the current write; waiting messages are dropped.
  virtual void end(const Error& why) = 0;
  // Ends the stream with DEADLINE_EXCEEDED if it has no session yet.
  virtual void end_without_session() = 0;
  // Ends the stream at once, even if the client does not read.
  virtual void abort() = 0;
};

inline constexpr int64_t kKeepaliveInterval_ns = 200'000'000;
// Interval of frames to a client that has the whole state of a scene at rest. Shorter than
// kKeepaliveInterval_ns, so that a frame takes the place of the empty message. Shorter values cost processor
// time at rest; with longer ones the tick that a client shows is older.
inline constexpr int64_t kRestInterval_ns = 150'000'000;

// The client of a session.
struct ClientIdentity {
  Authorization authorization;
  std::string name, peer;  // its own name, printable; its address
};

// The options of a Join; valid for all streams until the next Join.
struct JoinTerms {
  double max_bytes_s = std::numeric_limits<double>::infinity();
  int position_bits = 16;
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;
  uint64_t every = 1;            // every Nth tick is sent
  int64_t tick_ns = 11'111'111;  // tick interval
};

inline bool is_kernel_encoding(v1::JoinRequest::Encoding encoding) {
  return encoding == v1::JoinRequest::KERNELS || encoding == v1::JoinRequest::KERNELS_EXACT;
}

// Latencies of a session so far, milliseconds.
struct ClientTimes {
  DurationHistogram send_ms;        // from StartWrite to OnWriteDone
  DurationHistogram round_trip_ms;  // from writing a frame to its acknowledgement
  DurationHistogram staleness_ms;   // from the end of the step to the acknowledgement
};

// The session of one client from its Join on. It is joined, then streaming, and parked when its stream
// breaks, until the client joins again or the session times out. Events are collected from each Join on, so
// that none is lost before the stream opens. Nothing that a lost connection missed is kept: a parked session
// collects no events, park() and rejoin() discard the waiting ones, and the client receives all objects when
// it joins again (SessionTable::join). The client's side is client/stream/session/session_client.h. Streams
// of a session are numbered; messages of an earlier stream are ignored. Any thread.
class ClientSession {
 public:
  ClientSession(std::string session_id, SessionNumber session_number, int64_t joined_at_ns,
                ClientIdentity identity = {}, const JoinTerms& terms = {})
      : id(std::move(session_id)),
        number(session_number),
        who(std::move(identity)),
        joined_ns(joined_at_ns),
        last_message_ns(joined_at_ns),
        budget(std::make_shared<SendBudget>(terms.max_bytes_s)),
        terms_(terms) {
    window_.set_interval(terms_.tick_ns * static_cast<int64_t>(terms_.every));
  }

  const std::string id;
  const SessionNumber number;
  const ClientIdentity who;
  const int64_t joined_ns;
  std::atomic<int64_t> last_message_ns;  // time of the last message or Join
  std::atomic<uint64_t> bytes_sent{0};
  // The cap of the client, for its stream and for its fetches of assets, which may end after the session.
  const std::shared_ptr<SendBudget> budget;

  enum class State { Joined, Streaming, Parked };
  State state() const {
    std::lock_guard lock(mutex_);
    return state_;
  }

  // Resets the state as after the first Join. Returns the writer of the previous stream, which the caller
  // must abort.
  std::shared_ptr<SessionWriter> rejoin(int64_t now_ns, const JoinTerms& terms = {}) {
    std::lock_guard lock(mutex_);
    last_message_ns = now_ns;
    state_ = State::Joined;
    ++stream_;
    offered_ = false;
    terms_ = terms;
    budget->set_cap(terms.max_bytes_s);
    window_.set_interval(terms_.tick_ns * static_cast<int64_t>(terms_.every));
    window_.restart();
    return std::exchange(writer_, {}).lock();
  }
  struct Attached {
    uint64_t stream = 0;  // number of the stream
    JoinTerms terms;
  };
  // The client fetches an asset. Before its stream begins, this counts as a message.
  void fetches(int64_t now_ns) {
    std::lock_guard lock(mutex_);
    if (state_ == State::Joined) last_message_ns = now_ns;
  }
  // Attaches a new stream. Nothing if another stream is attached or the client must join again.
  std::optional<Attached> attach(std::weak_ptr<SessionWriter> writer) {
    std::lock_guard lock(mutex_);
    if (state_ != State::Joined) return std::nullopt;
    state_ = State::Streaming;
    writer_ = std::move(writer);
    return Attached{stream_, terms_};
  }
  // Parks the session when this stream ends. False if the session has moved to another stream.
  bool park(uint64_t stream) {
    std::lock_guard lock(mutex_);
    if (stream != stream_ || state_ != State::Streaming) return false;
    state_ = State::Parked;
    writer_.reset();
    window_.restart();
    return true;
  }
  // The current or expected stream, with its writer if there is one.
  struct Stream {
    std::shared_ptr<SessionWriter> writer;
    uint64_t number = 0;
  };
  Stream stream() const {
    std::lock_guard lock(mutex_);
    return {writer_.lock(), stream_};
  }
  std::shared_ptr<SessionWriter> writer() const { return stream().writer; }
  // Parks the session even if this stream was never attached. No effect if the session has moved to another
  // stream.
  void give_up(uint64_t stream) {
    std::lock_guard lock(mutex_);
    if (stream != stream_) return;
    state_ = State::Parked;
    writer_.reset();
    window_.restart();
  }

  // False if too many events wait; the stream must end.
  bool add_event(const v1::SessionEvent& event) {
    std::lock_guard lock(mutex_);
    return state_ == State::Parked || window_.add_event(event);
  }
  // The encoding requested at the last Join.
  v1::JoinRequest::Encoding encoding() const {
    std::lock_guard lock(mutex_);
    return terms_.encoding;
  }
  // Offers a tick, whose number is that of its frame. `kernels`: the kernel encoding that was added to the
  // tick; none for driver frames. Ignored if the client requested another encoding.
  void offer(std::shared_ptr<const TickEncodings> tick,
             std::optional<v1::JoinRequest::Encoding> kernels = {}) {
    std::lock_guard lock(mutex_);
    if (state_ == State::Parked ||
        (kernels ? terms_.encoding != *kernels : is_kernel_encoding(terms_.encoding)))
      return;
    // Clients with the same rate get the same ticks, so that they share encodings. If a tick is missing, the
    // next one takes its place.
    const uint64_t turn = tick->tick() / terms_.every;
    if (offered_ && turn == turn_) return;
    offered_ = true;
    turn_ = turn;
    window_.offer(std::move(tick));
  }
  // False if this is not the current stream of the session.
  bool acknowledge(uint64_t stream, uint64_t tick, int64_t now_ns) {
    std::lock_guard lock(mutex_);
    if (stream != stream_ || state_ != State::Streaming) return false;
    window_.acknowledge(tick, now_ns);
    return true;
  }
  std::optional<SendWindow::Outgoing> take(uint64_t stream, int64_t now_ns, bool frames = true) {
    std::lock_guard lock(mutex_);
    if (stream != stream_ || state_ != State::Streaming) return std::nullopt;
    return window_.take(now_ns, frames);
  }
  // See SendWindow::withdraw.
  void withdraw(uint64_t stream, uint64_t tick) {
    std::lock_guard lock(mutex_);
    if (stream == stream_) window_.withdraw(tick);
  }
  void add_send(double ms) {
    std::lock_guard lock(mutex_);
    times_.send_ms.add(ms);
  }
  void add_answer(double round_trip_ms, double staleness_ms) {
    std::lock_guard lock(mutex_);
    times_.round_trip_ms.add(round_trip_ms);
    times_.staleness_ms.add(staleness_ms);
  }
  ClientTimes times() const {
    std::lock_guard lock(mutex_);
    return times_;
  }
  // Maximum number of frames in flight.
  size_t window() const {
    std::lock_guard lock(mutex_);
    return window_.size();
  }
  uint64_t frames_sent() const {
    std::lock_guard lock(mutex_);
    return window_.sent();
  }
  uint64_t frames_replaced() const {
    std::lock_guard lock(mutex_);
    return window_.replaced();
  }

 private:
  mutable std::mutex mutex_;  // guards everything below; locked last, no calls while held
  State state_ = State::Joined;
  uint64_t stream_ = 1;
  SendWindow window_;
  JoinTerms terms_;
  uint64_t turn_ = 0;     // turn of the last offered tick
  bool offered_ = false;  // a tick was offered since this stream began
  ClientTimes times_;
  std::weak_ptr<SessionWriter> writer_;
};

}  // namespace livegs
