// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "livegs/v1/session.pb.h"
#include "session/published_tick.h"

namespace livegs {

// What one client is sent next, and when. gRPC's own flow control lets seconds of frames queue up before it
// pushes back, and OnWriteDone means "handed to the transport" only; so the client acknowledges frames, and
// no more than kMaxFramesInFlight are under way. A frame that has to wait is replaced by the next one: the
// newest wins. Events are kept, in order, and go out with the next write even when the window is shut.
//
// Not locked; no gRPC types.
class SendWindow {
 public:
  // Two: one being taken by the client while the next travels. Staleness is then at most twice the client's
  // own frame time, however slow it is.
  static constexpr size_t kMaxFramesInFlight = 2;
  // A client that lets so many events wait is not reading.
  static constexpr size_t kMaxWaitingEvents = 1024;

  void offer(std::shared_ptr<const PublishedTick> tick);
  // False when there are too many, and the client has to go.
  bool add_event(const v1::SessionEvent& event);
  // Everything up to `tick` has arrived. Numbers that were never sent change nothing.
  void acknowledge(uint64_t tick);

  struct Outgoing {
    std::shared_ptr<const PublishedTick> tick;  // nullptr: events only
    std::vector<v1::SessionEvent> events;
  };
  // What to write now, if there is anything that may be; it counts as sent. Without `frames`, events only.
  std::optional<Outgoing> take(bool frames = true);

  // As for a stream that begins: nothing waits, nothing is in flight. Counts go on.
  void restart();

  size_t in_flight() const { return in_flight_.size(); }
  uint64_t sent() const { return sent_; }
  uint64_t replaced() const { return replaced_; }

 private:
  std::shared_ptr<const PublishedTick> waiting_;
  std::vector<v1::SessionEvent> events_;
  std::deque<uint64_t> in_flight_;
  uint64_t sent_ = 0;
  uint64_t replaced_ = 0;
};

}  // namespace livegs
