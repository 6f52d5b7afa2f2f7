// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "session/access/authorization.h"
#include "session/frames/send_window.h"
#include "session/support/duration_histogram.h"
#include "session/tick/tick_result.h"

namespace livegs {

// The wire side of a session: woken when there may be something to write. Any thread.
class SessionWriter {
 public:
  virtual ~SessionWriter() = default;
  virtual void wake() = 0;
  // Writes a message of no content if nothing was written for kKeepaliveInterval_ns.
  virtual void send_keepalive(int64_t now_ns) = 0;
  // Writes what waits, then ends the stream with UNAVAILABLE and `reason`.
  virtual void close(const std::string& reason) = 0;
  // Ends the stream with the error as soon as the write that is under way is done. What waits is not written.
  virtual void end(const Error& why) = 0;
  // Ends the stream with DEADLINE_EXCEEDED if it has no session yet.
  virtual void end_without_session() = 0;
  // Ends the stream at once, whether or not the client still reads.
  virtual void abort() = 0;
};

inline constexpr int64_t kKeepaliveInterval_ns = 200'000'000;

// Who has a session.
struct ClientIdentity {
  Grant grant;
  std::string name, peer;  // as it calls itself, printable; its address
};

// What a client asked for when it joined; it holds for the streams that it opens until it joins again.
struct JoinTerms {
  double max_bytes_s = std::numeric_limits<double>::infinity();
  int position_bits = 16;
  v1::JoinRequest::Encoding encoding = v1::JoinRequest::DRIVERS;
  uint64_t every = 1;            // tick
  int64_t tick_ns = 11'111'111;  // between ticks
};

inline bool is_kernel_encoding(v1::JoinRequest::Encoding encoding) {
  return encoding == v1::JoinRequest::KERNELS || encoding == v1::JoinRequest::KERNELS_EXACT;
}

// How long things took in a session so far, milliseconds.
struct ClientTimes {
  DurationHistogram send_ms;        // from handing a message to gRPC to gRPC's having passed it on
  DurationHistogram round_trip_ms;  // from writing a frame to hearing that it was decoded
  DurationHistogram staleness_ms;   // from the end of its tick's step to that
};

// One client from Join on: joined, then streaming, and parked when its stream broke, until it joins again or
// its time is up. Events are collected from each Join, so that none is lost before its stream opens; a parked
// session collects none, since its client is told of all objects when it comes back. Streams of one session
// are numbered, and what the one before still says is not heard. Any thread.
class ClientSession {
 public:
  ClientSession(std::string session_id, SessionNumber session_number, int64_t joined_at_ns,
                ClientIdentity identity = {}, const JoinTerms& terms = {})
      : id(std::move(session_id)),
        number(session_number),
        who(std::move(identity)),
        joined_ns(joined_at_ns),
        heard_ns(joined_at_ns),
        terms_(terms) {
    window_.set_interval(terms_.tick_ns * static_cast<int64_t>(terms_.every));
  }

  const std::string id;
  const SessionNumber number;
  const ClientIdentity who;
  const int64_t joined_ns;
  std::atomic<int64_t> heard_ns;  // of the last message, or of Join
  std::atomic<uint64_t> bytes_sent{0};

  enum class State { Joined, Streaming, Parked };
  State state() const {
    std::lock_guard lock(mutex_);
    return state_;
  }

  // The client joined again: as after its first Join. Returns the writer of the stream it left, to be
  // aborted.
  std::shared_ptr<SessionWriter> rejoin(int64_t now_ns, const JoinTerms& terms = {}) {
    std::lock_guard lock(mutex_);
    heard_ns = now_ns;
    state_ = State::Joined;
    ++stream_;
    offered_ = false;
    terms_ = terms;
    window_.set_interval(terms_.tick_ns * static_cast<int64_t>(terms_.every));
    window_.restart();
    return std::exchange(writer_, {}).lock();
  }
  struct Attached {
    uint64_t stream = 0;  // its number
    JoinTerms terms;
  };
  // The stream that begins. Nothing if another stream has the session, or it has to join again.
  std::optional<Attached> attach(std::weak_ptr<SessionWriter> writer) {
    std::lock_guard lock(mutex_);
    if (state_ != State::Joined) return std::nullopt;
    state_ = State::Streaming;
    writer_ = std::move(writer);
    return Attached{stream_, terms_};
  }
  // That stream is over. False if the session has gone on without it.
  bool park(uint64_t stream) {
    std::lock_guard lock(mutex_);
    if (stream != stream_ || state_ != State::Streaming) return false;
    state_ = State::Parked;
    writer_.reset();
    window_.restart();
    return true;
  }
  // The stream it has or waits for, and what writes it, if anything does.
  struct Stream {
    std::shared_ptr<SessionWriter> writer;
    uint64_t number = 0;
  };
  Stream stream() const {
    std::lock_guard lock(mutex_);
    return {writer_.lock(), stream_};
  }
  std::shared_ptr<SessionWriter> writer() const { return stream().writer; }
  // That stream is over, whether it has begun or not. Nothing if the session has gone on to another.
  void give_up(uint64_t stream) {
    std::lock_guard lock(mutex_);
    if (stream != stream_) return;
    state_ = State::Parked;
    writer_.reset();
    window_.restart();
  }

  // False when its stream has to end: too many events wait.
  bool add_event(const v1::SessionEvent& event) {
    std::lock_guard lock(mutex_);
    return state_ == State::Parked || window_.add_event(event);
  }
  // What its frames are, as it joined last.
  v1::JoinRequest::Encoding encoding() const {
    std::lock_guard lock(mutex_);
    return terms_.encoding;
  }
  // `kernels`: which the tick has been given; without, it is for those who are sent drivers. Nothing for
  // those who asked for something else.
  void offer(std::shared_ptr<const TickEncodings> tick,
             std::optional<v1::JoinRequest::Encoding> kernels = {}) {
    std::lock_guard lock(mutex_);
    if (state_ == State::Parked ||
        (kernels ? terms_.encoding != *kernels : is_kernel_encoding(terms_.encoding)))
      return;
    // The same ticks for all of the same pace, so that they share bytes; should the one be left out, the next
    // in its place.
    const uint64_t turn = tick->tick() / terms_.every;
    if (offered_ && turn == turn_) return;
    offered_ = true;
    turn_ = turn;
    window_.offer(std::move(tick));
  }
  // False if this is not the session's stream any more.
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
  // How many frames may be under way.
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
  mutable std::mutex mutex_;  // guards everything below; taken last, never held while anything else is called
  State state_ = State::Joined;
  uint64_t stream_ = 1;
  SendWindow window_;
  JoinTerms terms_;
  uint64_t turn_ = 0;     // of the tick it was offered last
  bool offered_ = false;  // one since this stream began
  ClientTimes times_;
  std::weak_ptr<SessionWriter> writer_;
};

}  // namespace livegs
