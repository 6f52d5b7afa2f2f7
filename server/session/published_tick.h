// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "session/duration_histogram.h"
#include "session/stepped_tick.h"
#include "wire/frame_stream.h"

namespace livegs {

// The tail of a v1::ServerMessage: its field 15, `frame`, as it stands on the wire. Concatenated protobuf
// fields are one message, so every client's own header and this tail, which all share, make one.
// Reference-counted by gRPC where it is sent; what that is, only published_tick.cpp and stream_call.cpp
// know.
struct FrameTail;

// What encoding costs and gives, over all ticks. Any thread.
class EncodingRecord {
 public:
  struct Summary {
    double frame_bytes_p50 = 0, frame_bytes_p99 = 0, encode_ms_p50 = 0, encode_ms_p99 = 0;
    uint64_t encoded = 0;
    double frame_bytes_total = 0, encode_ms_total = 0;
  };
  void add(size_t bytes, double ms);
  Summary summary() const;

 private:
  mutable std::mutex mutex_;  // guards the two below
  DurationHistogram bytes_, ms_;
};

// A frame as it is written to streams that all have the same baseline.
struct EncodedFrame {
  std::shared_ptr<const FrameTail> tail;
  StreamBaselinePtr next;
};

// A tick, for any number of clients: encoded when the first of those that have the same baseline is written
// to. Immutable to who looks at it; any thread.
class PublishedTick {
 public:
  PublishedTick(DriverFrame frame, std::shared_ptr<EncodingRecord> record)
      : frame_(std::move(frame)), record_(std::move(record)) {}

  uint64_t tick() const { return frame_.tick; }
  int64_t stepped_ns = 0;
  double step_ms = 0;
  RunStatus run;
  std::vector<SessionHands> hands;  // ascending session

  // `written`: the baseline of what a stream has been written so far; null for a key frame.
  EncodedFrame against(const StreamBaselinePtr& written) const;

 private:
  const DriverFrame frame_;
  const std::shared_ptr<EncodingRecord> record_;
  struct Made {
    StreamBaselinePtr baseline;
    EncodedFrame frame;
  };
  mutable std::mutex mutex_;        // held while one is encoded: the others of that baseline wait for it
  mutable std::vector<Made> made_;  // few: clients that keep up have the same
};

}  // namespace livegs
