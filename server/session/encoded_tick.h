// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "session/stepped_tick.h"

namespace livegs {

// The tail of a v1::ServerMessage: its field 15, `frame`, as it stands on the wire. Concatenated protobuf
// fields are one message, so every client's own header and this tail, which all share, make one.
// Reference-counted by gRPC where it is sent; what that is, only frame_publisher.cpp and stream_call.cpp
// know.
struct FrameTail;

// A tick, encoded once and sent to many. Immutable.
struct EncodedTick {
  uint64_t tick = 0;
  int64_t stepped_ns = 0;
  double step_ms = 0;
  size_t frame_bytes = 0;
  std::shared_ptr<const FrameTail> tail;
  std::vector<SessionHands> hands;  // ascending session
};

}  // namespace livegs
