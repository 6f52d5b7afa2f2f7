// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/send_window.h"

namespace livegs {

void SendWindow::offer(std::shared_ptr<const PublishedTick> tick) {
  if (waiting_) ++replaced_;
  waiting_ = std::move(tick);
}

bool SendWindow::add_event(const v1::SessionEvent& event) {
  if (events_.size() >= kMaxWaitingEvents) return false;
  events_.push_back(event);
  return true;
}

void SendWindow::acknowledge(uint64_t tick) {
  while (!in_flight_.empty() && in_flight_.front() <= tick) in_flight_.pop_front();
}

std::optional<SendWindow::Outgoing> SendWindow::take(bool frames) {
  Outgoing outgoing;
  if (frames && waiting_ && in_flight_.size() < kMaxFramesInFlight) {
    in_flight_.push_back(waiting_->tick());
    outgoing.tick = std::move(waiting_);
    waiting_.reset();
    ++sent_;
  }
  if (!outgoing.tick && events_.empty()) return std::nullopt;
  outgoing.events = std::move(events_);
  events_.clear();
  return outgoing;
}

void SendWindow::restart() {
  waiting_.reset();
  events_.clear();
  in_flight_.clear();
}

}  // namespace livegs
