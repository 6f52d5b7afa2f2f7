// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/support/slice.h>

namespace livegs {

// See tick_encodings.h. The tag and length of field 15 and the bytes of the frame, in one reference-counted
// slice.
struct SharedFramePayload {
  grpc::Slice slice;
};

}  // namespace livegs
