// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>

#include "stream/received/stream_item.h"

namespace livegs {

// Between the stream's reader and a drawer that may be slower: everything in the order it came. Bounded: when
// more than `max_bytes` of frames wait, the oldest are dropped and counted, events never. Any thread.
class PlaybackQueue final : public ItemSource {
 public:
  explicit PlaybackQueue(size_t max_bytes) : max_bytes_(max_bytes) {}

  void add(StreamItem item);
  // No more will come; take() gives what waits and then nothing.
  void close();
  // The same, and what waits is not wanted either.
  void abandon();
  // The oldest item, waiting for one. Nothing when closed and empty.
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
