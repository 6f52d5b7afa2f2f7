// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <grpcpp/support/slice.h>

#include <cstddef>
#include <span>

namespace livegs {

// See encoded_tick.h. Tag and length of field 15, then the frame's bytes, in one slice that gRPC counts.
struct FrameTail {
  grpc::Slice slice;
};

FrameTail make_frame_tail(std::span<const std::byte> frame);

}  // namespace livegs
