// SPDX-License-Identifier: Apache-2.0
#include "stream/playback_queue.h"

#include <algorithm>

namespace livegs {

void PlaybackQueue::add(StreamItem item) {
  {
    std::lock_guard lock(mutex_);
    if (closed_) return;
    if (const auto* frame = std::get_if<ReceivedFrame>(&item)) bytes_ += frame->encoded.size();
    items_.push_back(std::move(item));
    while (bytes_ > most_bytes_) {
      const auto oldest = std::find_if(items_.begin(), items_.end(), [](const StreamItem& one) {
        return std::holds_alternative<ReceivedFrame>(one);
      });
      bytes_ -= std::get<ReceivedFrame>(*oldest).encoded.size();
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

std::optional<StreamItem> PlaybackQueue::take() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_ || !items_.empty(); });
  if (items_.empty()) return std::nullopt;
  StreamItem item = std::move(items_.front());
  items_.pop_front();
  if (const auto* frame = std::get_if<ReceivedFrame>(&item)) bytes_ -= frame->encoded.size();
  return item;
}

uint64_t PlaybackQueue::dropped_frames() const {
  std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace livegs
