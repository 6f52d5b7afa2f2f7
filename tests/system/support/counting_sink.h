// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>

#include "stream/session/session_client.h"

namespace livegs {

// Counts frames and drops them. While frozen, it blocks in on_frame.
class CountingSink : public StreamSink {
 public:
  void on_lost(const std::string&) override { ++lost; }
  void on_resumed(const ResumedSession&) override {}
  void on_frame(ReceivedFrame) override {
    ++frames;
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return !frozen_; });
  }
  void on_object_added(StreamedObject) override {}
  void on_object_changed(StreamedObject) override {}
  void on_object_removed(uint32_t) override {}
  void on_draining(const std::string&) override {}
  void freeze(bool frozen) {
    std::lock_guard lock(mutex_);
    frozen_ = frozen;
    changed_.notify_all();
  }

  std::atomic<uint64_t> frames{0}, lost{0};

 private:
  std::mutex mutex_;  // guards frozen_
  std::condition_variable changed_;
  bool frozen_ = false;
};

}  // namespace livegs
