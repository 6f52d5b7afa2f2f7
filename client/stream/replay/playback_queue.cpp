// SPDX-License-Identifier: Apache-2.0
#include "stream/replay/playback_queue.h"

#include <algorithm>

namespace livegs {
namespace {

// Approximate memory use of a frame.
size_t bytes_of(const ReceivedFrame& frame) {
  size_t bytes = sizeof(ReceivedFrame);
  if (!frame.drivers) return bytes;
  for (const ObjectDrivers& object : frame.drivers->objects) {
    bytes += sizeof(ObjectDrivers) + object.poses.size() * sizeof(Pose) +
             object.positions_m.size() * sizeof(Eigen::Vector3f) +
             object.rotations.size() * sizeof(Eigen::Quaternionf);
    constexpr size_t kKernelBytes =
        sizeof(Eigen::Vector3f) + sizeof(Symmetric3f) + sizeof(Eigen::Quaternionf);
    if (object.kernels) bytes += object.kernels->positions_m.size() * kKernelBytes;
  }
  return bytes;
}

}  // namespace

void PlaybackQueue::add(StreamItem item) {
  {
    std::lock_guard lock(mutex_);
    if (closed_) return;
    if (const auto* frame = std::get_if<ReceivedFrame>(&item)) bytes_ += bytes_of(*frame);
    items_.push_back(std::move(item));
    while (bytes_ > max_bytes_) {
      const auto oldest = std::find_if(items_.begin(), items_.end(), [](const StreamItem& one) {
        return std::holds_alternative<ReceivedFrame>(one);
      });
      bytes_ -= bytes_of(std::get<ReceivedFrame>(*oldest));
      items_.erase(oldest);
      ++dropped_;
    }
  }
  changed_.notify_one();
}

void PlaybackQueue::close() {
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
  }
  changed_.notify_all();
}

void PlaybackQueue::abandon() {
  {
    std::lock_guard lock(mutex_);
    closed_ = true;
    items_.clear();
    bytes_ = 0;
  }
  changed_.notify_all();
}

std::optional<StreamItem> PlaybackQueue::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_ || !items_.empty(); });
  if (items_.empty()) return std::nullopt;
  StreamItem item = std::move(items_.front());
  items_.pop_front();
  if (const auto* frame = std::get_if<ReceivedFrame>(&item)) bytes_ -= bytes_of(*frame);
  return item;
}

uint64_t PlaybackQueue::dropped_frames() const {
  std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace livegs
