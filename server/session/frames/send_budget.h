// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <limits>
#include <mutex>

#include "core/token_bucket.h"

namespace livegs {

// Bandwidth limit of one client: of its stream and of its fetches of assets together. A token bucket: any T
// seconds carry at most cap * (T + kBurst_s) bytes plus one message; see proto/frame_format.md, "Deferred
// objects". Frames have priority: they may spend the whole balance, and assets take what exceeds kFrameShare
// of a full bucket. Any thread.
class SendBudget {
 public:
  // Unused budget accumulates for this time, since frames of a sudden motion are larger than frames at rest.
  static constexpr double kBurst_s = 0.1;
  // Share of the full bucket that assets leave for frames. With less, a sudden motion is sent later while
  // assets are fetched.
  static constexpr double kFrameShare = 0.75;
  // Share of the full bucket from which a chunk of an asset is sent, 20 ms of the cap. With less, messages
  // are more and smaller; kFrameShare and this share must not exceed 1.
  static constexpr double kChunkShare = 0.2;
  // After this time one chunk is sent although frames take everything, so that a fetch makes progress: 2 % of
  // the cap.
  static constexpr int64_t kMaxAssetWait_ns = 1'000'000'000;
  // Upper bound of the bytes of a chunk's message that are not data.
  static constexpr size_t kChunkOverhead = 32;

  explicit SendBudget(double bytes_s = std::numeric_limits<double>::infinity()) { set_cap(bytes_s); }

  // Bytes a second; infinity: no cap. The accumulated budget is kept.
  void set_cap(double bytes_s);
  bool capped() const;

  // Bytes that a frame may have now; nothing if 0 or less.
  double available_bytes(int64_t now_ns);
  void pay(double bytes);

  // Turn of a fetch: the bytes of its next chunk, which are paid; or none, and the time after which the fetch
  // should ask again. Fetches get their chunks in turn. One that waits must call leave() when it ends.
  struct Turn {
    size_t bytes = 0;
    int64_t wait_ns = 0;
  };
  Turn take_turn(const void* fetch, size_t max_bytes, int64_t now_ns);
  void leave(const void* fetch);

 private:
  bool capped_now() const { return cap_bytes_s_ < std::numeric_limits<double>::infinity(); }

  mutable std::mutex mutex_;  // guards everything below
  double cap_bytes_s_ = std::numeric_limits<double>::infinity();
  TokenBucket bytes_{cap_bytes_s_, cap_bytes_s_};
  std::deque<const void*> waiting_;  // fetches, the next one first
  int64_t waiting_since_ns_ = 0;     // since the last chunk, or since the first fetch waits
};

}  // namespace livegs
