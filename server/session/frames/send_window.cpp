// SPDX-License-Identifier: GPL-3.0-or-later
// Counts the frames in flight to one client, by tick. The limit is computed in window_size.cpp.
#include "session/frames/send_window.h"

namespace livegs {

void SendWindow::offer(std::shared_ptr<const TickEncodings> tick) {
  if (waiting_) ++replaced_;
  waiting_ = std::move(tick);
}

bool SendWindow::add_event(const v1::SessionEvent& event) {
  if (events_.size() >= kMaxWaitingEvents) return false;
  events_.push_back(event);
  return true;
}

void SendWindow::acknowledge(uint64_t tick, int64_t now_ns) {
  InFlight newest;
  size_t frames = 0;
  for (; !in_flight_.empty() && in_flight_.front().tick <= tick; in_flight_.pop_front(), ++frames)
    newest = in_flight_.front();
  if (frames > 0 && newest.tick == tick) size_.add({newest.written_ns, now_ns, newest.alone, frames});
}

std::optional<SendWindow::Outgoing> SendWindow::take(int64_t now_ns, bool frames) {
  Outgoing outgoing;
  if (frames && waiting_ && in_flight_.size() < size_.frames()) {
    in_flight_.push_back({waiting_->tick(), now_ns, in_flight_.empty()});
    outgoing.tick = std::move(waiting_);
    waiting_.reset();
    ++sent_;
  }
  if (!outgoing.tick && events_.empty()) return std::nullopt;
  outgoing.slow = size_.slow(now_ns);
  outgoing.events = std::move(events_);
  events_.clear();
  return outgoing;
}

void SendWindow::withdraw(uint64_t tick) {
  if (in_flight_.empty() || in_flight_.back().tick != tick) return;  // a client may acknowledge any tick
  in_flight_.pop_back();
  --sent_;
}

void SendWindow::restart() {
  waiting_.reset();
  events_.clear();
  in_flight_.clear();
  size_ = {};
  size_.set_interval(interval_ns_);
}

}  // namespace livegs
