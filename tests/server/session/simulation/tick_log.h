// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <vector>

#include "patience.h"
#include "session/tick/tick_result.h"

namespace livegs {

// Stores every tick.
class TickLog final : public TickSink {
 public:
  void publish(TickResult&& tick) override {
    {
      std::lock_guard lock(mutex_);
      ticks_.push_back(std::move(tick));
    }
    changed_.notify_all();
  }
  // Waits until the ticks so far satisfy `enough`.
  bool wait(const std::function<bool(const std::vector<TickResult>&)>& enough) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, kPatience, [&] { return enough(ticks_); });
  }
  void clear() {
    std::lock_guard lock(mutex_);
    ticks_.clear();
  }
  std::vector<TickResult> ticks() const {
    std::lock_guard lock(mutex_);
    return ticks_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<TickResult> ticks_;
};

// The mean of an object's drivers.
inline Eigen::Vector3d middle_of(const DriverFrame& frame, uint32_t object_id) {
  for (const ObjectDrivers& object : frame.objects) {
    if (object.object_id != object_id) continue;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Pose& pose : object.poses) sum += pose.position_m;
    for (const Eigen::Vector3f& position : object.positions_m) sum += position.cast<double>();
    return sum / static_cast<double>(object.poses.size() + object.positions_m.size());
  }
  return Eigen::Vector3d::Constant(1e9);
}

// A right hand at `position_m` that points along -z.
inline InputSample hand_sample(uint64_t sequence, const Eigen::Vector3d& position_m, float trigger,
                               bool shoot = false) {
  InputSample sample;
  sample.sequence = sequence;
  sample.hands[1].active = true;
  sample.hands[1].aim.position_m = sample.hands[1].grip.position_m = position_m;
  sample.hands[1].trigger = trigger;
  sample.hands[1].shoot = shoot;
  return sample;
}

}  // namespace livegs
