// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/input_sample.h"
#include "wire/little_endian.h"

// Lossless codec of input samples. See proto/recording_format.md, "A sample".

namespace livegs {

// Numbers per sample. For each hand: aim position and orientation x, y, z, w, then the same of grip. Then
// trigger and squeeze of each hand.
inline constexpr size_t kPoseValues = 28, kSampleValues = 32;

// The previous sample of a session; default: none.
struct SampleBefore {
  uint64_t sequence = 0;
  int64_t sampled_ns = 0;
  std::array<uint32_t, kSampleValues> bits{};
};

// `tick`: the tick at which the sample was applied. `before` is updated to this sample.
void write_sample(ByteWriter& out, const InputSample& sample, uint64_t tick, SampleBefore& before);
// Empty if the bytes are not a sample: truncated, a reserved bit, or a value that is not finite.
std::optional<InputSample> read_sample(ByteReader& in, uint64_t tick, SampleBefore& before);

}  // namespace livegs
