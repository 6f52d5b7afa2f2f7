// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/published_tick.h"

#include <grpc/slice.h>

#include <cstring>

#include "core/clock.h"
#include "livegs/v1/session.pb.h"
#include "session/frame_tail.h"

namespace livegs {
namespace {

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

}  // namespace

void EncodingRecord::add(size_t bytes, double ms) {
  std::lock_guard lock(mutex_);
  bytes_.add(static_cast<double>(bytes));
  ms_.add(ms);
}

EncodingRecord::Summary EncodingRecord::summary() const {
  std::lock_guard lock(mutex_);
  return {bytes_.percentile(0.50), bytes_.percentile(0.99), ms_.percentile(0.50), ms_.percentile(0.99),
          ms_.count(),             bytes_.sum(),            ms_.sum()};
}

EncodedFrame PublishedTick::against(const StreamBaselinePtr& written) const {
  // A stream's ticks grow; should they not, it begins anew.
  const StreamBaselinePtr baseline = written && tick_of(*written) < frame_.tick ? written : nullptr;
  std::lock_guard lock(mutex_);
  for (const Made& made : made_) {
    if (made.baseline == baseline) return made.frame;
  }
  const int64_t begun_ns = now_ns();
  EncodedStreamFrame encoded = encode_stream_frame(frame_, baseline);
  if (record_) record_->add(encoded.bytes.size(), milliseconds_from_ns(now_ns() - begun_ns));
  EncodedFrame frame{std::make_shared<const FrameTail>(make_frame_tail(encoded.bytes)),
                     std::move(encoded.next)};
  made_.push_back({baseline, frame});
  return frame;
}

}  // namespace livegs
