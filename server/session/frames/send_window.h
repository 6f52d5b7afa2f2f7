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

// What one client is sent next, and when. gRPC's own flow control lets seconds of frames queue up before it
// pushes back, and OnWriteDone means "handed to the transport" only; so the client acknowledges frames, and
// no more than WindowSize says, one to four, are under way. A frame that has to wait is replaced by the next
// one: the newest wins. Events are kept, in order, and go out with the next write even when the window is
// shut.
//
// Not locked; no gRPC types.
class SendWindow {
 public:
  // A client that lets so many events wait is not reading.
  static constexpr size_t kMaxWaitingEvents = 1024;

  // Between the ticks that are offered.
  void set_interval(int64_t interval_ns) { interval_ns_ = interval_ns, size_.set_interval(interval_ns); }
  void offer(std::shared_ptr<const TickEncodings> tick);
  // False when there are too many, and the client has to go.
  bool add_event(const v1::SessionEvent& event);
  // Everything up to `tick` has arrived. Numbers that were never sent change nothing.
  void acknowledge(uint64_t tick, int64_t now_ns);

  struct Outgoing {
    std::shared_ptr<const TickEncodings> tick;  // nullptr: events only
    std::vector<v1::SessionEvent> events;
    bool slow = false;  // WindowSize::slow()
  };
  // What to write now, if there is anything that may be; it counts as sent. Without `frames`, events only.
  std::optional<Outgoing> take(int64_t now_ns, bool frames = true);

  // As for a stream that begins: nothing waits, nothing is in flight. Counts go on.
  void restart();

  size_t in_flight() const { return in_flight_.size(); }
  size_t size() const { return size_.frames(); }  // how many may be
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
