// SPDX-License-Identifier: Apache-2.0
#include "stream/received/frame_history.h"

#include <algorithm>
#include <limits>

namespace livegs {
namespace {

template <class Quaternion>
Quaternion nlerp(const Quaternion& a, const Quaternion& b, typename Quaternion::Scalar share) {
  const auto sign = a.dot(b) < 0 ? typename Quaternion::Scalar(-1) : typename Quaternion::Scalar(1);
  return Quaternion((a.coeffs() * (1 - share) + b.coeffs() * (sign * share)).normalized());
}

// Whether drivers can be interpolated.
bool match(const ObjectDrivers& a, const ObjectDrivers& b) {
  return !a.kernels && !b.kernels && a.kind == b.kind && a.revision == b.revision &&
         a.poses.size() == b.poses.size() && a.positions_m.size() == b.positions_m.size() &&
         a.rotations.size() == b.rotations.size();
}

// A body at rest keeps its exact bits, so that it is not skinned again.
template <class Quaternion>
void turn(Quaternion& a, const Quaternion& b, typename Quaternion::Scalar share) {
  if (a.coeffs() != b.coeffs()) a = nlerp(a, b, share);
}

void interpolate(ObjectDrivers& a, const ObjectDrivers& b, double share) {
  a.asleep = a.asleep && b.asleep;
  const auto share_f = static_cast<float>(share);
  for (size_t i = 0; i < a.poses.size(); ++i) {
    a.poses[i].position_m += share * (b.poses[i].position_m - a.poses[i].position_m);
    turn(a.poses[i].orientation, b.poses[i].orientation, share);
  }
  for (size_t i = 0; i < a.positions_m.size(); ++i) {
    a.positions_m[i] += share_f * (b.positions_m[i] - a.positions_m[i]);
  }
  for (size_t i = 0; i < a.rotations.size(); ++i) turn(a.rotations[i], b.rotations[i], share_f);
}

// The object with this id, searched from `from` on; objects are sorted by id.
using Objects = std::vector<ObjectDrivers>;
Objects::const_iterator find(Objects::const_iterator from, Objects::const_iterator end, uint32_t object_id) {
  while (from != end && from->object_id < object_id) ++from;
  return from;
}

}  // namespace

bool same_drivers(const DriverFrame& a, const DriverFrame& b) {
  const auto same_pose = [](const Pose& one, const Pose& other) {
    return one.position_m == other.position_m && one.orientation.coeffs() == other.orientation.coeffs();
  };
  const auto same_turn = [](const Eigen::Quaternionf& one, const Eigen::Quaternionf& other) {
    return one.coeffs() == other.coeffs();
  };
  return std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(),
                    [&](const ObjectDrivers& one, const ObjectDrivers& other) {
                      return match(one, other) && one.object_id == other.object_id &&
                             std::equal(one.poses.begin(), one.poses.end(), other.poses.begin(), same_pose) &&
                             one.positions_m == other.positions_m &&
                             std::equal(one.rotations.begin(), one.rotations.end(), other.rotations.begin(),
                                        same_turn);
                    });
}

DriverFrame interpolate(const DriverFrame& a, const DriverFrame& b, double share) {
  DriverFrame between = a;
  between.simulated_ns += static_cast<int64_t>(share * static_cast<double>(b.simulated_ns - a.simulated_ns));
  auto other = b.objects.begin();
  for (ObjectDrivers& object : between.objects) {
    other = find(other, b.objects.end(), object.object_id);
    if (other != b.objects.end() && other->object_id == object.object_id && match(object, *other)) {
      interpolate(object, *other, share);
    }
  }
  return between;
}

DriverFrame extrapolate(const DriverFrame& a, const DriverFrame& b, double share) {
  DriverFrame beyond = b;
  beyond.simulated_ns +=
      static_cast<int64_t>((share - 1) * static_cast<double>(b.simulated_ns - a.simulated_ns));
  auto other = a.objects.begin();
  for (ObjectDrivers& object : beyond.objects) {
    other = find(other, a.objects.end(), object.object_id);
    if (object.asleep || other == a.objects.end() || other->object_id != object.object_id) continue;
    if (!match(*other, object)) continue;
    ObjectDrivers gone_on = *other;
    interpolate(gone_on, object, share);
    object = std::move(gone_on);
  }
  return beyond;
}

std::optional<int64_t> FrameHistory::add(DriverFrame frame) {
  if (!frames_.empty() && frame.simulated_ns <= frames_.back().simulated_ns) return std::nullopt;
  std::optional<int64_t> repeated_ns;
  if (frames_.size() >= 2) {
    const DriverFrame &newest = frames_.back(), &before = frames_[frames_.size() - 2];
    const uint64_t ticks = frame.tick > newest.tick ? frame.tick - newest.tick : 0;
    if (ticks > 1 && same_drivers(before, newest)) {
      DriverFrame repeated = newest;
      repeated.simulated_ns =
          frame.simulated_ns - (frame.simulated_ns - newest.simulated_ns) / static_cast<int64_t>(ticks);
      repeated.tick = frame.tick - 1;
      repeated_ns = repeated.simulated_ns;
      push(std::move(repeated));
    }
  }
  push(std::move(frame));
  return repeated_ns;
}

void FrameHistory::push(DriverFrame frame) {
  frames_.push_back(std::move(frame));
  if (frames_.size() > max_frames_) frames_.pop_front();
}

std::optional<DriverFrame> FrameHistory::at(int64_t simulated_ns) const {
  if (frames_.empty()) return std::nullopt;
  const auto later =
      std::upper_bound(frames_.begin(), frames_.end(), simulated_ns,
                       [](int64_t moment, const DriverFrame& frame) { return moment < frame.simulated_ns; });
  if (later == frames_.begin()) return frames_.front();
  const DriverFrame& before = *(later - 1);
  if (before.simulated_ns == simulated_ns) return before;
  if (later == frames_.end()) {
    if (frames_.size() < 2) return before;
    const DriverFrame& last = frames_[frames_.size() - 2];
    const int64_t beyond_ns = std::min(simulated_ns - before.simulated_ns, kFramesAhead * shortest_ns());
    const auto interval = static_cast<double>(before.simulated_ns - last.simulated_ns);
    return extrapolate(last, before, 1.0 + static_cast<double>(beyond_ns) / interval);
  }
  const double share = static_cast<double>(simulated_ns - before.simulated_ns) /
                       static_cast<double>(later->simulated_ns - before.simulated_ns);
  return interpolate(before, *later, share);
}

int64_t FrameHistory::shortest_ns() const {
  int64_t shortest = std::numeric_limits<int64_t>::max();
  for (size_t i = 1; i < frames_.size(); ++i)
    shortest = std::min(shortest, frames_[i].simulated_ns - frames_[i - 1].simulated_ns);
  return shortest;
}

void FrameHistory::drop_before(int64_t simulated_ns) {
  while (frames_.size() > 1 && frames_[1].simulated_ns <= simulated_ns) frames_.pop_front();
}

}  // namespace livegs
