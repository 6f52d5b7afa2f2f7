// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "livegs/v1/session.pb.h"
#include "session/frames/tick_encodings.h"
#include "session/frames/window_size.h"

namespace livegs {

// Flow control for one client. It counts the frames in flight: written, but not acknowledged. Each is
// identified by its tick; there is no other number (skin/driver_frame.h), and SceneRun::advance counts it. An
// acknowledgement of a tick covers all earlier ones. WindowSize (window_size.h) sets the limit.
//
// gRPC buffers seconds of frames before it applies back pressure, and OnWriteDone means only that the
// transport has the message; acknowledgements are therefore needed. A frame that has to wait is replaced by
// the next one. Events are kept in order and go out with the next write, even when the window is full.
//
// Not locked; no gRPC types.
class SendWindow {
 public:
  // More waiting events than this mean that the client does not read.
  static constexpr size_t kMaxWaitingEvents = 1024;

  // Time between offered ticks.
  void set_interval(int64_t interval_ns) { interval_ns_ = interval_ns, size_.set_interval(interval_ns); }
  void offer(std::shared_ptr<const TickEncodings> tick);
  // False if too many events wait; the stream must end.
  bool add_event(const v1::SessionEvent& event);
  // The client has received everything up to `tick`. Ticks that were never sent are ignored.
  void acknowledge(uint64_t tick, int64_t now_ns);

  struct Outgoing {
    std::shared_ptr<const TickEncodings> tick;  // nullptr: events only
    std::vector<v1::SessionEvent> events;
    bool slow = false;  // WindowSize::slow()
  };
  // The next message, which then counts as sent; nothing if there is none. Without `frames`, events only.
  std::optional<Outgoing> take(int64_t now_ns, bool frames = true);
  // The frame of the last take() was not written, because the client has all that is in it.
  void withdraw(uint64_t tick);

  // Resets the state for a new stream; the counters continue.
  void restart();

  size_t in_flight() const { return in_flight_.size(); }
  size_t size() const { return size_.frames(); }  // the window, in frames
  uint64_t sent() const { return sent_; }
  uint64_t replaced() const { return replaced_; }

 private:
  std::shared_ptr<const TickEncodings> waiting_;
  std::vector<v1::SessionEvent> events_;
  struct InFlight {
    uint64_t tick = 0;
    int64_t written_ns = 0;
    bool alone = false;
  };
  std::deque<InFlight> in_flight_;
  int64_t interval_ns_ = 11'111'111;
  WindowSize size_;
  uint64_t sent_ = 0;
  uint64_t replaced_ = 0;
};

}  // namespace livegs
