// SPDX-License-Identifier: Apache-2.0
// Frames of a stream, one after the other, as a client's reader sees them (proto/frame_format.md, "Streams").
#include <zstd.h>

#include "fuzz/moving_objects.h"
#include "wire/frame_stream.h"
#include "wire/stream_layout.h"

namespace livegs::fuzz {
namespace {

// The same frame with its body as it is, so that what is spoilt reaches the parts behind the compression.
Bytes uncompressed(const Bytes& frame) {
  using namespace stream_layout;
  if (!(std::to_integer<uint8_t>(frame[2]) & kCompressed)) return frame;
  ByteReader in(frame);
  in.skip(3);
  (void)read_varint(in);
  in.skip(8);
  if (!(std::to_integer<uint8_t>(frame[2]) & kKeyFrame)) (void)read_varint(in);
  const size_t head = in.offset();
  const auto size = read_varint(in);
  Bytes plain(frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(head));
  plain[2] &= ~std::byte{kCompressed};
  plain.resize(head + *size);
  const size_t made = ZSTD_decompress(plain.data() + head, *size, frame.data() + in.offset(), frame.size() - in.offset());
  check(made == *size, "a frame of ours decompresses");
  return plain;
}

}  // namespace

void look_at(std::span<const std::byte> input) {
  StreamReader reader;
  for (const auto part : parts_of(input)) {
    const auto frame = reader.read(part);
    check(reader.needs_key_frame() == !frame, "who could not read a frame asks for a key frame, and nobody else");
    if (!frame) continue;
    check_finite(*frame);
    const auto time_ns = stream_frame_time_ns(part);
    check(time_ns && *time_ns == frame->simulated_ns, "the head tells the time of the frame");
    for (size_t i = 1; i < frame->objects.size(); ++i)
      check(frame->objects[i - 1].object_id < frame->objects[i].object_id, "ids ascend");
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  for (const bool hashed : {false, true}) {
    for (const uint64_t stride : {1, 3}) {
      StreamBaselinePtr baseline;
      std::vector<Bytes> frames, plain;
      StreamOptions options;
      options.hash_interval = hashed ? 2 : 0;
      for (uint64_t i = 0; i < 8; ++i) {
        EncodedStreamFrame encoded = encode_stream_frame(frame_at(1 + i * stride), baseline, options);
        baseline = encoded.next;
        if (!hashed) plain.push_back(uncompressed(encoded.bytes));
        frames.push_back(std::move(encoded.bytes));
        seeds.push_back(joined(frames));
      }
      if (!hashed) seeds.push_back(joined(plain));
      if (!hashed) seeds.push_back(joined({plain[0], plain[1]}));
    }
  }
  return seeds;
}

}  // namespace livegs::fuzz
