// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "livegs/v1/session.pb.h"
#include "session/frames/frame_selection.h"
#include "session/support/duration_histogram.h"
#include "session/tick/tick_result.h"
#include "wire/frame_stream.h"

namespace livegs {

// The tail of a v1::ServerMessage: its field 15, `frame`, as it stands on the wire. Concatenated protobuf
// fields are one message, so every client's own header and this tail, which all share, make one.
// Reference-counted by gRPC where it is sent; what that is, only published_tick.cpp and stream_call.cpp
// know.
struct SharedFramePayload;

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
  std::shared_ptr<const SharedFramePayload> tail;
  StreamBaselinePtr next;
  size_t bytes = 0;
};

// By object id, v1::ObjectDescription.reach_m.
using ObjectReaches = std::map<uint32_t, double>;

// A tick, for any number of clients: encoded when the first of those that have the same is written to. One
// that missed a frame is encoded for by itself, and three frames later has what the others have. Immutable to
// who looks at it; any thread.
class TickEncodings {
 public:
  TickEncodings(DriverFrame frame, std::shared_ptr<EncodingRecord> record)
      : frame_(std::move(frame)), record_(std::move(record)) {}

  uint64_t tick() const { return frame_.tick; }
  const DriverFrame& drivers() const { return frame_; }
  int64_t stepped_ns = 0;
  double step_ms = 0;
  RunStatus run;
  std::vector<SessionHands> hands;               // ascending session
  std::shared_ptr<const ObjectReaches> reaches;  // null: everything is seen by everybody

  // With all that moved, at 16 bits. `written`: the baseline of what a stream has been written so far; null
  // for a key frame.
  EncodedFrame against(const StreamBaselinePtr& written) const;
  // Without what does not fit and, to a client that is not uncongested, what it does not see;
  // proto/frame_format.md, "What a frame leaves out".
  EncodedFrame for_client(const StreamBaselinePtr& written, const ClientView& who,
                          double budget_bytes = std::numeric_limits<double>::infinity()) const;
  // Whole, and to be read without any before, for those who asked for another encoding than DRIVERS.
  // Precondition: kernels have been kept.
  EncodedFrame keyframe(v1::JoinRequest::Encoding encoding) const;
  void keep(v1::JoinRequest::Encoding encoding, std::vector<std::byte> frame);

 private:
  EncodedFrame encoded(const StreamBaselinePtr& baseline, const std::vector<uint32_t>& left_out,
                       int position_bits) const;
  size_t encodings() const;  // so far
  std::span<const ObjectBall> balls() const;
  // A stream's ticks grow; should they not, it begins anew.
  StreamBaselinePtr usable(const StreamBaselinePtr& written) const {
    return written && tick_of(*written) < frame_.tick ? written : nullptr;
  }

  const DriverFrame frame_;
  const std::shared_ptr<EncodingRecord> record_;
  struct Made {
    StreamBaselinePtr baseline;
    std::vector<uint32_t> left_out;
    int position_bits;
    EncodedFrame frame;
  };
  mutable std::mutex mutex_;  // held while one is encoded: the others of that baseline wait for it
  mutable std::once_flag balls_made_;
  mutable std::vector<ObjectBall> balls_;
  mutable std::vector<Made> made_;  // few: clients that keep up are alike
  mutable std::map<v1::JoinRequest::Encoding, EncodedFrame> keyframes_;
};

}  // namespace livegs
