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

// The tail of a v1::ServerMessage: its field 15, `frame`, in wire format. Concatenated protobuf fields form
// one message, so each client's own header plus this shared tail is one message. gRPC counts the references.
// Defined only for tick_encodings.cpp and stream_call.cpp (shared_frame_payload.h).
struct SharedFramePayload;

// Encoding times and sizes over all ticks. Any thread.
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

// An encoded frame for all streams with the same baseline.
struct EncodedFrame {
  std::shared_ptr<const SharedFramePayload> tail;
  StreamBaselinePtr next;
  size_t bytes = 0;
  bool unchanged = false;  // the baseline has all that is in the tick
};

// v1::ObjectDescription.reach_m by object id.
using ObjectReaches = std::map<uint32_t, double>;

// One tick for any number of clients. Each variant is encoded once, at the first write that needs it. A
// client that missed a frame needs its own encoding and shares again three frames later. The observable state
// is immutable; any thread.
class TickEncodings {
 public:
  TickEncodings(DriverFrame frame, std::shared_ptr<EncodingRecord> record)
      : frame_(std::move(frame)), record_(std::move(record)) {}

  uint64_t tick() const { return frame_.tick; }
  const DriverFrame& drivers() const { return frame_; }
  int64_t stepped_ns = 0;
  double step_ms = 0;
  RunStatus run;
  std::vector<SessionHands> hands;               // ordered by session
  std::shared_ptr<const ObjectReaches> reaches;  // null: no culling

  // The frame with all moved objects, at 16 bits. `written`: the baseline of the stream; null for a keyframe.
  EncodedFrame against(const StreamBaselinePtr& written) const;
  // Omits objects that exceed the budget and, for congested clients, objects outside the view; see
  // proto/frame_format.md, "Deferred objects".
  EncodedFrame for_client(const StreamBaselinePtr& written, const ClientView& who,
                          double budget_bytes = std::numeric_limits<double>::infinity()) const;
  // A keyframe for clients with an encoding other than DRIVERS. Precondition for kernels: keep() was called.
  EncodedFrame keyframe(v1::JoinRequest::Encoding encoding) const;
  void keep(v1::JoinRequest::Encoding encoding, std::vector<std::byte> frame);

 private:
  EncodedFrame encoded(const StreamBaselinePtr& baseline, const std::vector<uint32_t>& left_out,
                       int position_bits) const;
  size_t encodings() const;
  std::span<const ObjectBall> balls() const;
  // Ticks of a stream increase; otherwise it restarts with a keyframe.
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
  mutable std::mutex mutex_;  // held during encoding: other clients with that baseline wait for it
  mutable std::once_flag balls_made_;
  mutable std::vector<ObjectBall> balls_;
  mutable std::vector<Made> made_;  // few: clients that keep up share
  mutable std::map<v1::JoinRequest::Encoding, EncodedFrame> keyframes_;
};

}  // namespace livegs
