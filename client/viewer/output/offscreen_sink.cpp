// SPDX-License-Identifier: Apache-2.0
#include "viewer/output/offscreen_sink.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/clock.h"
#include "core/log.h"

namespace livegs {
namespace {

constexpr double kLastFrameTimeout_s = 1;  // maximum wait after the nominal end

std::optional<Eigen::Vector3d> middle_of(const DriverFrame& frame, uint32_t object_id) {
  const auto object = std::find_if(frame.objects.begin(), frame.objects.end(),
                                   [&](const ObjectDrivers& one) { return one.object_id == object_id; });
  if (object == frame.objects.end()) return std::nullopt;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Pose& pose : object->poses) sum += pose.position_m;
  for (const Eigen::Vector3f& position : object->positions_m) sum += position.cast<double>();
  size_t count = object->poses.size() + object->positions_m.size();
  if (object->kernels) {
    for (const Eigen::Vector3f& position : object->kernels->positions_m) sum += position.cast<double>();
    count += object->kernels->positions_m.size();
  }
  if (count == 0) return std::nullopt;
  return sum / static_cast<double>(count);
}

}  // namespace

void OffscreenSink::on_lost(const std::string& reason) {
  std::lock_guard lock(mutex_);
  ++outages_.count;
  outages_.last_reason = reason;
}

void OffscreenSink::on_resumed(const ResumedSession& resumed) {
  {
    std::lock_guard lock(mutex_);
    ++outages_.resumed;
    outages_.restarted += resumed.same_server ? 0 : 1;
    outages_.seconds += resumed.outage_s;
    if (!resumed.same_server) {
      ticks_reset_ = true;
      log_.reset();
    }
  }
  queue_.add(resumed);
}

double OffscreenSink::time_s(const ReceivedFrame& frame) const {
  return static_cast<double>(static_cast<int64_t>(frame.tick) - first_tick_) / client_.scene().rate_hz;
}

void OffscreenSink::on_frame(ReceivedFrame frame) {
  {
    std::lock_guard lock(mutex_);
    if (done_) return;
    if (first_ns_ == 0) {
      first_ns_ = frame.received_ns;
      first_tick_ = static_cast<int64_t>(frame.tick);
    } else if (ticks_reset_) {  // the script continues at the current time
      const double now_s = last_time_s_ + seconds_from_ns(frame.received_ns - last_ns_);
      first_tick_ = static_cast<int64_t>(frame.tick) - std::llround(now_s * client_.scene().rate_hz);
    }
    ticks_reset_ = false;
    last_ns_ = frame.received_ns;
    last_time_s_ = time_s(frame);
    log_.add(frame);
    play_script(frame);
    if (seconds_ > 0 && seconds_from_ns(frame.received_ns - first_ns_) >= seconds_) {
      done_ = true;
      changed_.notify_all();
    }
  }
  queue_.add(std::move(frame));
}

void OffscreenSink::play_script(const ReceivedFrame& frame) {
  if (!hands_) return;
  const auto locate = [&](const std::string& name) -> std::optional<ObjectExtent> {
    const auto target = targets_.find(name);
    if (target == targets_.end()) return std::nullopt;
    const auto middle = middle_of(*frame.drivers, target->second.object_id);
    if (!middle) return std::nullopt;
    return ObjectExtent{*middle, target->second.size_m};
  };
  client_.send(hands_->at(time_s(frame), locate));
}

void OffscreenSink::on_object_added(StreamedObject object) {
  assets_.request(object);
  {
    std::lock_guard lock(mutex_);
    changed_objects_[object.id] = object;
  }
  queue_.add(ObjectAdded{std::move(object)});
}

void OffscreenSink::on_object_changed(StreamedObject object) {
  assets_.request(object);
  {
    std::lock_guard lock(mutex_);
    changed_objects_[object.id] = object;
  }
  queue_.add(ObjectChanged{std::move(object)});
}

void OffscreenSink::on_object_removed(uint32_t object_id) { queue_.add(ObjectRemoved{object_id}); }

void OffscreenSink::on_draining(const std::string& reason) {
  log_info("server: shutting down: %s", reason.c_str());
  std::lock_guard lock(mutex_);
  draining_reason_ = reason;
  done_ = true;
  changed_.notify_all();
}

void OffscreenSink::begin_script(ScriptedHands hands, std::map<std::string, Target> targets) {
  std::lock_guard lock(mutex_);
  hands_.emplace(std::move(hands));
  targets_ = std::move(targets);
}

bool OffscreenSink::wait_done(double seconds) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return done_; });
  if (done_ || seconds_ == 0) return done_;
  gave_up_ = first_ns_ == 0 && seconds_from_ns(now_ns() - made_ns_) >= patience_s();
  done_ =
      gave_up_ || (first_ns_ != 0 && seconds_from_ns(now_ns() - first_ns_) >= seconds_ + kLastFrameTimeout_s);
  return done_;
}

bool OffscreenSink::gave_up() const {
  std::lock_guard lock(mutex_);
  return gave_up_;
}

std::string OffscreenSink::draining_reason() const {
  std::lock_guard lock(mutex_);
  return draining_reason_;
}

OffscreenSink::Outages OffscreenSink::outages() const {
  std::lock_guard lock(mutex_);
  return outages_;
}

std::map<uint32_t, StreamedObject> OffscreenSink::changed_objects() const {
  std::lock_guard lock(mutex_);
  return changed_objects_;
}

ReceivedLog::Summary OffscreenSink::summary() const {
  std::lock_guard lock(mutex_);
  return log_.summary();
}

}  // namespace livegs
