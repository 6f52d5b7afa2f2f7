// SPDX-License-Identifier: GPL-3.0-or-later
#include "session/frames/tick_encodings.h"

#include <grpc/slice.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/assert.h"
#include "core/clock.h"
#include "session/frames/shared_frame_payload.h"
#include "wire/frame_codec.h"

namespace livegs {
namespace {

SharedFramePayload make_frame_tail(std::span<const std::byte> frame) {
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

// Encodings per tick beyond which uncapped clients share one. More encodings would delay frames until the
// clients appear slow.
constexpr size_t kMaxSharedEncodings = 8;

EncodedFrame whole_frame(std::span<const std::byte> frame) {
  return {std::make_shared<const SharedFramePayload>(make_frame_tail(frame)), nullptr, frame.size()};
}

}  // namespace

void EncodingRecord::add(size_t bytes, double ms) {
  std::lock_guard lock(mutex_);
  bytes_.add(static_cast<double>(bytes));
  ms_.add(ms);
}

EncodingRecord::Summary EncodingRecord::summary() const {
  std::lock_guard lock(mutex_);
  return {bytes_.percentile(0.50),
          bytes_.percentile(0.99),
          ms_.percentile(0.50),
          ms_.percentile(0.99),
          ms_.count(),
          bytes_.sum(),
          ms_.sum()};
}

EncodedFrame TickEncodings::against(const StreamBaselinePtr& written) const {
  return encoded(usable(written), {}, 16);
}

EncodedFrame TickEncodings::for_client(const StreamBaselinePtr& written, const ClientView& who,
                                       double budget_bytes) const {
  const StreamBaselinePtr baseline = usable(written);
  if (!baseline) return encoded(nullptr, {}, who.position_bits);
  std::vector<uint32_t> left_out;
  const bool shares = who.uncongested || (std::isinf(budget_bytes) && encodings() >= kMaxSharedEncodings);
  if (who.view && !shares) left_out = culled(balls(), who, frame_.tick, tick_of(*baseline));
  const EncodedFrame whole = encoded(baseline, left_out, who.position_bits);
  if (static_cast<double>(whole.bytes) <= budget_bytes) return whole;
  return encoded(
      baseline,
      over_budget(frame_, *baseline, balls(), who, left_out, static_cast<double>(whole.bytes), budget_bytes),
      who.position_bits);
}

size_t TickEncodings::encodings() const {
  std::lock_guard lock(mutex_);
  return made_.size();
}

EncodedFrame TickEncodings::keyframe(v1::JoinRequest::Encoding encoding) const {
  std::lock_guard lock(mutex_);
  auto made = keyframes_.find(encoding);
  if (made == keyframes_.end()) {
    LIVEGS_ASSERT(encoding == v1::JoinRequest::DRIVERS_RAW);
    const int64_t begun_ns = now_ns();
    const std::vector<std::byte> frame = encode_frame(frame_, DriverEncoding::Raw);
    if (record_) record_->add(frame.size(), milliseconds_from_ns(now_ns() - begun_ns));
    made = keyframes_.emplace(encoding, whole_frame(frame)).first;
  }
  return made->second;
}

void TickEncodings::keep(v1::JoinRequest::Encoding encoding, std::vector<std::byte> frame) {
  std::lock_guard lock(mutex_);
  keyframes_[encoding] = whole_frame(frame);
}

std::span<const ObjectBall> TickEncodings::balls() const {
  std::call_once(balls_made_, [this] {
    if (!reaches) return;
    for (const ObjectDrivers& object : frame_.objects) {
      const auto reach = reaches->find(object.object_id);
      if (reach != reaches->end() && reach->second > 0) balls_.push_back(ball_around(object, reach->second));
    }
  });
  return balls_;
}

EncodedFrame TickEncodings::encoded(const StreamBaselinePtr& baseline, const std::vector<uint32_t>& left_out,
                                    int position_bits) const {
  std::lock_guard lock(mutex_);
  for (const Made& made : made_) {
    if (made.left_out != left_out || made.position_bits != position_bits) continue;
    if (made.baseline == baseline || (made.baseline && baseline && same_state(*made.baseline, *baseline)))
      return made.frame;
  }
  const int64_t begun_ns = now_ns();
  StreamOptions options;
  options.precision = precision_of(position_bits);
  if (!left_out.empty())
    options.leave_out = [&](uint32_t id) { return std::binary_search(left_out.begin(), left_out.end(), id); };
  EncodedStreamFrame made = encode_stream_frame(frame_, baseline, options);
  if (record_) record_->add(made.bytes.size(), milliseconds_from_ns(now_ns() - begun_ns));
  EncodedFrame frame{std::make_shared<const SharedFramePayload>(make_frame_tail(made.bytes)),
                     std::move(made.next), made.bytes.size(),
                     baseline && made.object_count == 0 && left_out.empty()};
  made_.push_back({baseline, left_out, position_bits, frame});
  return frame;
}

}  // namespace livegs
