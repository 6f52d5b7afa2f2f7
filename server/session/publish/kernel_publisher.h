// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <vector>

#include "session/frames/kernel_poser.h"
#include "session/sessions/session_table.h"

namespace livegs {

// For clients that cannot skin: moves and encodes the kernels of ticks on a thread of its own, so that
// neither the others' frames nor a tick wait for it, and hands them to those who asked for them. When it
// falls behind, the newest tick wins. While nobody asks it does no more than keep account of what there is.
class KernelPublisher {
 public:
  explicit KernelPublisher(SessionTable& table);
  ~KernelPublisher();

  // What there is before the first tick.
  void begin_with(std::span<const SceneObject* const> objects);
  // What comes, changes and goes with the next tick that is published. What is told twice is taken once. Any
  // thread, one at a time, as the next; both return at once.
  void take(std::span<const SceneObject> added, std::span<const SceneObject> changed,
            std::span<const uint32_t> removed);
  void publish(std::shared_ptr<TickEncodings> tick);

 private:
  void run();
  void note_time(int64_t took_ns, size_t bytes);

  SessionTable& table_;
  KernelPoser poser_;    // the thread's, like the next
  size_t slow_ = 0;      // frames, one after the other, that took long
  bool warned_ = false;  // of them

  std::mutex mutex_;  // guards everything below but the thread
  std::condition_variable changed_;
  std::shared_ptr<TickEncodings> waiting_;
  std::vector<SceneObject> objects_;  // in order; ids are never used twice, so those that went go last
  std::vector<uint32_t> removed_;
  bool taken_ = false;  // since the last tick
  bool stopping_ = false;

  std::thread thread_;
};

}  // namespace livegs
