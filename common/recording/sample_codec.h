// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/input_sample.h"
#include "wire/little_endian.h"

// What hands did, as bytes and back to the very same bits; proto/recording_format.md, "A sample".

namespace livegs {

// The numbers of a sample: of each hand aim position and orientation x, y, z, w, then grip's; then trigger
// and squeeze of each.
inline constexpr size_t kPoseValues = 28, kSampleValues = 32;

// The sample of a session before this one; as it is made: none.
struct SampleBefore {
  uint64_t sequence = 0;
  int64_t sampled_ns = 0;
  std::array<uint32_t, kSampleValues> bits{};
};

// `tick`: the one it was applied at. `before` becomes this one.
void write_sample(ByteWriter& out, const InputSample& sample, uint64_t tick, SampleBefore& before);
// Nothing where the bytes are no sample: cut short, a reserved bit, a value that is not finite.
std::optional<InputSample> read_sample(ByteReader& in, uint64_t tick, SampleBefore& before);

}  // namespace livegs
