// SPDX-License-Identifier: Apache-2.0
// Successive frames of a stream, as a client's reader receives them (proto/frame_format.md, "Streams").
#include "fuzz/moving_objects.h"
#include "wire/frame_stream.h"

namespace livegs::fuzz::stream_frames_fuzz {
void look_at(std::span<const std::byte> input) {
  StreamReader reader;
  for (const auto part : parts_of(input)) {
    const auto frame = reader.read(part);
    check(reader.needs_keyframe() == !frame,
          "a keyframe is requested if and only if the frame could not be read");
    if (!frame) continue;
    check_finite(*frame);
    const auto time_ns = stream_frame_time_ns(part);
    check(time_ns && *time_ns == frame->simulated_ns, "the head has the time of the frame");
    for (size_t i = 1; i < frame->objects.size(); ++i)
      check(frame->objects[i - 1].object_id < frame->objects[i].object_id, "object ids ascend");
  }
}

std::vector<Bytes> seeds() {
  std::vector<Bytes> seeds;
  for (const bool hashed : {false, true}) {
    for (const uint64_t stride : {1, 3}) {
      StreamBaselinePtr baseline;
      std::vector<Bytes> frames;
      StreamOptions options;
      options.hash_interval = hashed ? 2 : 0;
      for (uint64_t i = 0; i < 8; ++i) {
        EncodedStreamFrame encoded = encode_stream_frame(frame_at(1 + i * stride), baseline, options);
        baseline = encoded.next;
        frames.push_back(std::move(encoded.bytes));
        seeds.push_back(joined(frames));
      }
    }
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"stream_frames", look_at, seeds});

}  // namespace livegs::fuzz::stream_frames_fuzz
