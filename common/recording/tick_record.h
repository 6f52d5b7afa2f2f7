// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/input_sample.h"
#include "core/result.h"
#include "livegs/v1/recording.pb.h"
#include "recording/driver_hash.h"
#include "recording/sample_codec.h"

// One tick of a recording; proto/recording_format.md, "Tick".

namespace livegs {

struct SessionSamples {
  uint64_t session = 0;
  std::vector<InputSample> samples;  // oldest first
};

// What one tick took from outside, in the order in which it is applied. From the same scene, the same actions
// give the same bits.
struct TickActions {
  std::vector<v1::SceneChange> changes;
  std::vector<uint64_t> over;           // sessions
  std::vector<SessionSamples> samples;  // ascending session
  std::vector<uint64_t> released;       // sessions
  std::vector<uint32_t> cuts;           // objects, in their order
  bool stepped = true;

  // Nothing but the step.
  bool empty() const {
    return changes.empty() && over.empty() && samples.empty() && released.empty() && cuts.empty();
  }
};

struct TickRecord {
  uint64_t tick = 0;
  bool key = false;
  std::optional<v1::SceneSource> scene;  // took the place of the one before
  TickActions actions;
  std::vector<ObjectHash> hashes;  // of objects that are not as they were
  std::vector<std::byte> frame;    // of a stream; empty: none
};

// The samples before, by session; a key tick begins anew.
using SamplesBefore = std::map<uint64_t, SampleBefore>;

std::vector<std::byte> encode_tick(const TickRecord& record, SamplesBefore& before);
// Accepts any bytes. After an error `before` is of no use until a key tick.
Result<TickRecord> decode_tick(std::span<const std::byte> bytes, SamplesBefore& before);

}  // namespace livegs
