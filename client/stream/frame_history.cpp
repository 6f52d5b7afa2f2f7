// SPDX-License-Identifier: Apache-2.0
#include "stream/frame_history.h"

#include <algorithm>

namespace livegs {
namespace {

template <class Quaternion>
Quaternion nlerp(const Quaternion& a, const Quaternion& b, typename Quaternion::Scalar share) {
  const auto sign = a.dot(b) < 0 ? typename Quaternion::Scalar(-1) : typename Quaternion::Scalar(1);
  return Quaternion((a.coeffs() * (1 - share) + b.coeffs() * (sign * share)).normalized());
}

bool same_drivers(const ObjectDrivers& a, const ObjectDrivers& b) {
  return a.kind == b.kind && a.revision == b.revision && a.poses.size() == b.poses.size() &&
         a.positions_m.size() == b.positions_m.size() && a.rotations.size() == b.rotations.size();
}

void interpolate(ObjectDrivers& a, const ObjectDrivers& b, double share) {
  a.asleep = a.asleep && b.asleep;
  const auto share_f = static_cast<float>(share);
  for (size_t i = 0; i < a.poses.size(); ++i) {
    a.poses[i].position_m += share * (b.poses[i].position_m - a.poses[i].position_m);
    a.poses[i].orientation = nlerp(a.poses[i].orientation, b.poses[i].orientation, share);
  }
  for (size_t i = 0; i < a.positions_m.size(); ++i) {
    a.positions_m[i] += share_f * (b.positions_m[i] - a.positions_m[i]);
  }
  for (size_t i = 0; i < a.rotations.size(); ++i)
    a.rotations[i] = nlerp(a.rotations[i], b.rotations[i], share_f);
}

}  // namespace

DriverFrame interpolate(const DriverFrame& a, const DriverFrame& b, double share) {
  DriverFrame between = a;
  between.simulated_ns += static_cast<int64_t>(share * static_cast<double>(b.simulated_ns - a.simulated_ns));
  auto other = b.objects.begin();
  for (ObjectDrivers& object : between.objects) {  // both ascend by id
    while (other != b.objects.end() && other->object_id < object.object_id) ++other;
    if (other != b.objects.end() && other->object_id == object.object_id && same_drivers(object, *other)) {
      interpolate(object, *other, share);
    }
  }
  return between;
}

void FrameHistory::add(DriverFrame frame) {
  if (!frames_.empty() && frame.simulated_ns <= frames_.back().simulated_ns) return;
  frames_.push_back(std::move(frame));
  if (frames_.size() > most_frames_) frames_.pop_front();
}

std::optional<DriverFrame> FrameHistory::at(int64_t simulated_ns) const {
  if (frames_.empty()) return std::nullopt;
  const auto later =
      std::upper_bound(frames_.begin(), frames_.end(), simulated_ns,
                       [](int64_t moment, const DriverFrame& frame) { return moment < frame.simulated_ns; });
  if (later == frames_.begin()) return frames_.front();
  const DriverFrame& before = *(later - 1);
  if (later == frames_.end() || before.simulated_ns == simulated_ns) return before;
  const double share = static_cast<double>(simulated_ns - before.simulated_ns) /
                       static_cast<double>(later->simulated_ns - before.simulated_ns);
  return interpolate(before, *later, share);
}

void FrameHistory::forget_before(int64_t simulated_ns) {
  while (frames_.size() > 1 && frames_[1].simulated_ns <= simulated_ns) frames_.pop_front();
}

}  // namespace livegs
