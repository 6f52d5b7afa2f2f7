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

// One tick of a recording. See proto/recording_format.md, "Tick".

namespace livegs {

struct SessionSamples {
  uint64_t session = 0;
  std::vector<InputSample> samples;  // oldest first
};

// External input of one tick, in the order in which it is applied. The same scene and the same actions give
// the same bits.
struct TickActions {
  std::vector<v1::SceneChange> changes;
  std::vector<uint64_t> over;           // sessions that ended
  std::vector<SessionSamples> samples;  // ascending session
  std::vector<uint64_t> released;       // sessions that released everything
  std::vector<uint32_t> cuts;           // objects that were cut, in order
  bool stepped = true;

  // Whether the tick is only a step.
  bool empty() const {
    return changes.empty() && over.empty() && samples.empty() && released.empty() && cuts.empty();
  }
};

struct TickRecord {
  uint64_t tick = 0;
  bool key = false;
  std::optional<v1::SceneSource> scene;  // the scene that replaced the previous one
  TickActions actions;
  std::vector<ObjectHash> hashes;  // of objects whose hash changed
  std::vector<std::byte> frame;    // stream frame; empty: none
};

// The previous samples by session; a key tick starts again from none.
using SamplesBefore = std::map<uint64_t, SampleBefore>;

std::vector<std::byte> encode_tick(const TickRecord& record, SamplesBefore& before);
// Accepts any bytes. After an error, `before` is invalid until the next key tick.
Result<TickRecord> decode_tick(std::span<const std::byte> bytes, SamplesBefore& before);

}  // namespace livegs
