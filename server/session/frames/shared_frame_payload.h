// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/support/slice.h>

namespace livegs {

// See published_tick.h. Tag and length of field 15, then the frame's bytes, in one slice that gRPC counts.
struct SharedFramePayload {
  grpc::Slice slice;
};

}  // namespace livegs
