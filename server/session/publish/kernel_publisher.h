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

// Poses and encodes the kernels of ticks for clients that cannot skin, on its own thread, so that driver
// frames and ticks are not delayed. If it falls behind, it skips to the newest tick. Without such clients
// it only tracks objects.
class KernelPublisher {
 public:
  explicit KernelPublisher(SessionTable& table);
  ~KernelPublisher();

  // Objects that exist before the first tick.
  void begin_with(std::span<const SceneObject* const> objects);
  // Objects added, changed and removed with the next published tick; duplicates are ignored. Any thread, one
  // call at a time, as for publish(). Both return at once.
  void take(std::span<const SceneObject> added, std::span<const SceneObject> changed,
            std::span<const uint32_t> removed);
  void publish(std::shared_ptr<TickEncodings> tick);

 private:
  void run();
  void note_time(int64_t took_ns, size_t bytes);

  SessionTable& table_;
  KernelPoser poser_;    // accessed by the thread only, like the next two
  size_t slow_ = 0;      // consecutive slow frames
  bool warned_ = false;  // about slow frames

  std::mutex mutex_;  // guards everything below except the thread
  std::condition_variable changed_;
  std::shared_ptr<TickEncodings> waiting_;
  std::vector<SceneObject> objects_;  // in order; ids are never reused, so removals apply last
  std::vector<uint32_t> removed_;
  bool taken_ = false;  // objects changed since the last tick
  bool stopping_ = false;

  std::thread thread_;
};

}  // namespace livegs
