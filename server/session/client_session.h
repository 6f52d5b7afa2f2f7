// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>

#include "session/send_window.h"
#include "session/stepped_tick.h"

namespace livegs {

// The wire side of a session: woken when there may be something to write. Any thread.
class SessionWriter {
 public:
  virtual ~SessionWriter() = default;
  virtual void wake() = 0;
  // Writes what waits, then ends the stream with UNAVAILABLE and `reason`.
  virtual void close(const std::string& reason) = 0;
  // Ends the stream at once, whether or not the client still reads.
  virtual void abort() = 0;
};

// One client from Join on. Its events are collected from that moment, so that none is lost before its stream
// opens.
class ClientSession {
 public:
  ClientSession(std::string session_id, SessionNumber session_number, int64_t joined_ns)
      : id(std::move(session_id)), number(session_number), heard_ns(joined_ns) {}

  const std::string id;
  const SessionNumber number;
  std::atomic<int64_t> heard_ns;  // of the last message, or of Join
  std::atomic<bool> streaming{false};

  // False if another stream has it already.
  bool attach(std::weak_ptr<SessionWriter> writer) {
    if (streaming.exchange(true)) return false;
    std::lock_guard lock(mutex_);
    writer_ = std::move(writer);
    return true;
  }
  std::shared_ptr<SessionWriter> writer() const {
    std::lock_guard lock(mutex_);
    return writer_.lock();
  }

  bool add_event(const v1::SessionEvent& event) {
    std::lock_guard lock(mutex_);
    return window_.add_event(event);
  }
  void offer(std::shared_ptr<const PublishedTick> tick) {
    std::lock_guard lock(mutex_);
    window_.offer(std::move(tick));
  }
  void acknowledge(uint64_t tick) {
    std::lock_guard lock(mutex_);
    window_.acknowledge(tick);
  }
  std::optional<SendWindow::Outgoing> take() {
    std::lock_guard lock(mutex_);
    return window_.take();
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
  mutable std::mutex mutex_;  // guards the two below; taken last, never held while anything else is called
  SendWindow window_;
  std::weak_ptr<SessionWriter> writer_;
};

}  // namespace livegs
