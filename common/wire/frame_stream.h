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

// Driver frames of one ordered, reliable stream, each coded as the difference from those written before. See
// proto/frame_format.md, "Streams". Both ends keep the same integers, so errors do not accumulate. Unchanged
// objects take no space. The tick is the only sequence number of a frame. It is counted in
// SceneRun::advance (server/session/simulation/scene_run.cpp); a stream may skip ticks.

namespace livegs {

// State of the reader of a stream after a frame. Immutable; shared by all streams that received the same
// frames, which can then share the bytes of the next one too.
class StreamBaseline;
using StreamBaselinePtr = std::shared_ptr<const StreamBaseline>;

struct EncodedStreamFrame {
  std::vector<std::byte> bytes;
  StreamBaselinePtr next;  // the baseline of the stream after these bytes
  // Objects in the bytes; the reader keeps the state of the others.
  size_t object_count = 0;
};

struct StreamOptions {
  GridPrecision precision;
  // Interval in ticks between hashes of the complete reader state, sent with the first frame of each
  // interval. 0: no hashes.
  uint32_t hash_interval = 32;
  // Whether a keyframe contains the known neighbours of a lattice. They reduce the size of every later
  // frame.
  bool send_neighbours = true;
  // Object ids to leave at the state of the reader although they moved. New objects are never left out.
  std::function<bool(uint32_t object_id)> leave_out;
};

// `baseline` null: a keyframe, which needs no earlier frame. Object ids are unique, in any order; ticks
// increase along a stream. Preconditions as for encode_frame. Any thread.
EncodedStreamFrame encode_stream_frame(const DriverFrame& frame, const StreamBaselinePtr& baseline,
                                       const StreamOptions& options = {});

// The frame as seen by the reader of the stream, objects by ascending id.
DriverFrame frame_of(const StreamBaseline& baseline);
uint64_t tick_of(const StreamBaseline& baseline);
// Whether readers with these baselines can read the same next frames. Streams that received different frames
// become equal again after two common frames that contain all moving objects.
bool same_state(const StreamBaseline& a, const StreamBaseline& b);

// Simulated time of the frame; reads only the header.
Result<int64_t> stream_frame_time_ns(std::span<const std::byte> bytes);

class StreamReader {
 public:
  // Called by FrameReader of the client (client/stream/received/frame_reader.h). The predecessor named in the
  // frame must be the last frame read (stream_reader.cpp).
  // Accepts any bytes. An error leaves the reader unchanged. After an error, only the frame that follows the
  // last one read or a keyframe can be read. Memory is bounded by kMaxFrameBytes and the current state.
  Result<DriverFrame> read(std::span<const std::byte> bytes);
  // True before the first keyframe, and after a frame that could not be read.
  bool needs_keyframe() const { return baseline_ == nullptr || failed_; }

 private:
  StreamBaselinePtr baseline_;
  bool failed_ = false;
};

}  // namespace livegs
