// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "core/result.h"
#include "skin/driver_frame.h"
#include "wire/driver_grid.h"

// Driver frames of one ordered, reliable stream, each against those written to it before;
// proto/frame_format.md, "Streams". Both ends keep the same integers, so nothing drifts. What did not change
// costs nothing.

namespace livegs {

// What the reader of a stream has after a frame. Immutable; shared by all streams that were sent the same
// frames, which can then share the next one's bytes too.
class StreamBaseline;
using StreamBaselinePtr = std::shared_ptr<const StreamBaseline>;

struct EncodedStreamFrame {
  std::vector<std::byte> bytes;
  StreamBaselinePtr next;  // the baseline of the stream once these bytes are written to it
  // Objects that are in the bytes; the others are as the reader has them.
  size_t object_count = 0;
};

struct StreamOptions {
  GridPrecision precision;
  // Of so many ticks, the first that the stream is sent carries a hash of everything the reader should have.
  // 0: none.
  uint32_t hash_interval = 32;
  // Whether a key frame tells who stands beside whom in a lattice, where that is known: what a stream saves
  // by in every frame.
  bool tell_neighbours = true;
  // Object ids to leave as the reader has them although they moved; new ones are never left out.
  std::function<bool(uint32_t object_id)> leave_out;
};

// `baseline` null: a key frame, which needs nothing before it. Ids ascend or not, each occurs once; ticks
// grow along a stream. Preconditions as for encode_frame. Any thread.
EncodedStreamFrame encode_stream_frame(const DriverFrame& frame, const StreamBaselinePtr& baseline,
                                       const StreamOptions& options = {});

// The frame as the reader of the stream sees it, objects by ascending id.
DriverFrame frame_of(const StreamBaseline& baseline);
uint64_t tick_of(const StreamBaseline& baseline);
// Whether readers that have the one and the other can read the same next frames. Streams that were sent
// different frames are alike again once two of the same have brought everything that moves.
bool same_state(const StreamBaseline& a, const StreamBaseline& b);

// Simulated time of the frame, by its head alone.
Result<int64_t> stream_frame_time_ns(std::span<const std::byte> bytes);

class StreamReader {
 public:
  // Accepts any bytes. An error leaves the reader as it was; unless the next frame is the one that belongs
  // here, only a key frame helps (ask for one). Memory is bounded by kMaxFrameBytes and what was read before.
  Result<DriverFrame> read(std::span<const std::byte> bytes);
  // Before the first key frame, and after a frame that could not be read.
  bool needs_key_frame() const { return baseline_ == nullptr || failed_; }

 private:
  StreamBaselinePtr baseline_;
  bool failed_ = false;
};

}  // namespace livegs
