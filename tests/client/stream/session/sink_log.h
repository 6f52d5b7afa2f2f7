// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "core/clock.h"
#include "patience.h"
#include "stream/received/received.h"

namespace livegs {

// Records the events of a session in order.
class SinkLog final : public StreamSink {
 public:
  struct State {
    std::vector<ReceivedFrame> frames;
    std::vector<std::string> lost;
    std::vector<ResumedSession> resumed;
    std::vector<size_t> resumed_at;  // number of frames at that time
    std::vector<StreamedObject> added, changed;
    std::vector<size_t> changed_at;  // number of frames at that time
    std::vector<uint32_t> removed;
    std::string draining;
    std::string moving;  // "REASON to ADDRESS"
  };

  void on_lost(const std::string& reason) override {
    note([&](State& state) { state.lost.push_back(reason); });
  }
  void on_resumed(const ResumedSession& resumed) override {
    note([&](State& state) {
      state.resumed.push_back(resumed);
      state.resumed_at.push_back(state.frames.size());
    });
  }
  void on_frame(ReceivedFrame frame) override {
    note([&](State& state) { state.frames.push_back(std::move(frame)); });
  }
  void on_object_added(StreamedObject object) override {
    note([&](State& state) { state.added.push_back(std::move(object)); });
  }
  void on_object_changed(StreamedObject object) override {
    note([&](State& state) {
      state.changed.push_back(std::move(object));
      state.changed_at.push_back(state.frames.size());
    });
  }
  void on_object_removed(uint32_t object_id) override {
    note([&](State& state) { state.removed.push_back(object_id); });
  }
  void on_moving(const std::string& reason, const std::string& address) override {
    note([&](State& state) { state.moving = reason + " to " + address; });
  }
  void on_draining(const std::string& reason) override {
    note([&](State& state) { state.draining = reason; });
  }

  // Waits until the state satisfies `enough`; false on a timeout of kPatience.
  bool wait(const std::function<bool(const State&)>& enough) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return enough(state_); });
  }
  bool wait_frames(size_t more) {
    const size_t before = state().frames.size();
    return wait([&](const State& state) { return state.frames.size() >= before + more; });
  }
  // Waits for `count` resumptions and a frame after the last.
  bool wait_resumed(size_t count) {
    return wait([&](const State& state) {
      return state.resumed.size() >= count && state.frames.size() > state.resumed_at.back();
    });
  }
  State state() const {
    std::lock_guard lock(mutex_);
    return state_;
  }

 private:
  void note(const std::function<void(State&)>& change) {
    {
      std::lock_guard lock(mutex_);
      change(state_);
    }
    changed_.notify_all();
  }

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_;
};

}  // namespace livegs
