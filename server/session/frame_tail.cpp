// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frame_tail.h"

#include <grpc/slice.h>

#include <cstdint>
#include <cstring>

#include "livegs/v1/session.pb.h"

namespace livegs {

FrameTail make_frame_tail(std::span<const std::byte> frame) {
  // Protocol Buffers encoding: (field << 3 | 2) for bytes, then the length, both as varints.
  uint8_t prefix[16];
  size_t length = 0;
  const auto put_varint = [&](uint64_t value) {
    for (; value >= 0x80; value >>= 7) prefix[length++] = static_cast<uint8_t>(value | 0x80);
    prefix[length++] = static_cast<uint8_t>(value);
  };
  put_varint(v1::ServerMessage::kFrameFieldNumber << 3 | 2);
  put_varint(frame.size());
  grpc_slice slice = grpc_slice_malloc(length + frame.size());
  std::memcpy(GRPC_SLICE_START_PTR(slice), prefix, length);
  if (!frame.empty()) std::memcpy(GRPC_SLICE_START_PTR(slice) + length, frame.data(), frame.size());
  return {grpc::Slice(slice, grpc::Slice::STEAL_REF)};
}

}  // namespace livegs
