// SPDX-License-Identifier: Apache-2.0
#include "viewer/panels/frame_meter.h"

#include "core/clock.h"

namespace livegs {
namespace {

constexpr size_t kGraphLength = 180, kMaxSamples = 512;
constexpr int64_t kSecond_ns = 1'000'000'000;

void add(std::vector<float>& values, double value) {
  if (values.size() == kGraphLength) values.erase(values.begin());
  values.push_back(static_cast<float>(value));
}

}  // namespace

void FrameMeter::sampled(uint64_t sequence, int64_t sampled_ns) {
  samples_.push_back({sequence, sampled_ns});
  if (samples_.size() > kMaxSamples) samples_.pop_front();
}

void FrameMeter::shown(const ReceivedFrame& frame, int64_t shown_ns, double picture_ms,
                       const std::optional<DeviceTimes>& device) {
  second_.push_back({shown_ns, frame.tick});
  while (second_.size() > 2 && second_.front().shown_ns < shown_ns - kSecond_ns) second_.pop_front();
  add(graph_.picture_ms, picture_ms);
  add(graph_.tick_ms, frame.step_ms);
  if (device) add(graph_.device_ms, device->total_ms());
  add(graph_.age_ms, milliseconds_from_ns(shown_ns - frame.received_ns));
  while (samples_.size() > 1 && samples_[1].sequence <= frame.input_sequence) samples_.pop_front();
  if (!samples_.empty() && samples_.front().sequence == frame.input_sequence) {
    hand_to_picture_ms_ = milliseconds_from_ns(shown_ns - samples_.front().sampled_ns);
  }
}

double FrameMeter::pictures_a_second() const {
  if (second_.size() < 2) return 0;
  return static_cast<double>(second_.size() - 1) /
         seconds_from_ns(second_.back().shown_ns - second_.front().shown_ns);
}

double FrameMeter::ticks_a_second() const {
  if (second_.size() < 2 || second_.back().tick < second_.front().tick) return 0;
  return static_cast<double>(second_.back().tick - second_.front().tick) /
         seconds_from_ns(second_.back().shown_ns - second_.front().shown_ns);
}

}  // namespace livegs
