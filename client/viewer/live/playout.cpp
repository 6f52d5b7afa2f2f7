// SPDX-License-Identifier: Apache-2.0
#include "viewer/live/playout.h"

namespace livegs {

void Playout::add(ReceivedFrame frame) {
  const bool changes = history_.empty() || !same_drivers(history_.newest(), *frame.drivers);
  const auto repeated_ns = history_.add(*frame.drivers);
  clock_.arrived(frame.drivers->simulated_ns, frame.received_ns, repeated_ns);
  if (changes) changed_ns_ = frame.drivers->simulated_ns;
  waiting_.push_back(std::move(frame));
  if (waiting_.size() > kFramesKept) waiting_.pop_front();
}

std::optional<DriverFrame> Playout::at(int64_t now_ns, int64_t displayed_ns) {
  if (history_.empty()) return std::nullopt;
  const int64_t moment_ns = moment_ns_ = clock_.at(now_ns, displayed_ns);
  while (!waiting_.empty() && (!shown_ || waiting_.front().drivers->simulated_ns <= moment_ns)) {
    shown_ = std::move(waiting_.front());
    waiting_.pop_front();
  }
  return history_.at(moment_ns);
}

}  // namespace livegs
