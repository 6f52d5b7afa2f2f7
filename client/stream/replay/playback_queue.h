// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

#include "stream/received/stream_item.h"

namespace livegs {

// A queue between the stream's reader and a possibly slower renderer; items keep their order. When more than
// `max_bytes` of frames wait, the oldest frames are dropped and counted. Events are never dropped. Any
// thread.
class PlaybackQueue final : public ItemSource {
 public:
  explicit PlaybackQueue(size_t max_bytes) : max_bytes_(max_bytes) {}

  void add(StreamItem item);
  // Ends the input; take() returns the remaining items and then nothing.
  void close();
  // Ends the input and discards the remaining items.
  void abandon();
  // Waits for the oldest item. Nothing when closed and empty.
  std::optional<StreamItem> take() override;

  uint64_t dropped_frames() const;

 private:
  const size_t max_bytes_;
  mutable std::mutex mutex_;  // guards everything below
  std::condition_variable changed_;
  std::deque<StreamItem> items_;
  size_t bytes_ = 0;
  uint64_t dropped_ = 0;
  bool closed_ = false;
};

}  // namespace livegs
