// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "wire/driver_grid.h"
#include "wire/frame_stream.h"
#include "wire/little_endian.h"
#include "wire/residual_planes.h"
#include "wire/varint.h"

// What writing and reading a frame of a stream have in common; proto/frame_format.md, "Streams". For these
// two alone.

namespace livegs {

namespace stream_layout {
inline constexpr uint8_t kMagic = 0xD6;
inline constexpr uint8_t kVersion = 1;
inline constexpr uint8_t kKeyFrame = 1, kCompressed = 2, kHashed = 4;
inline constexpr uint8_t kModeBits = 3, kAsleepBit = 4, kKindShift = 3;
inline constexpr int kMaxPlanes = 4;
inline constexpr int kLevel = 1;
inline constexpr size_t kWorthCompressing = 64;  // fewer bytes are sent as they are
inline constexpr int32_t kMaxGap = 16;           // ticks over which a straight line is believed
inline constexpr int kMinExponent = -30, kMaxExponent = 30;

}  // namespace stream_layout

// One object as the reader has it, and its integers one frame of its own earlier.
struct GridHistory {
  DriverGrid now;
  uint64_t tick = 0;
  std::vector<int32_t> earlier;  // empty: there is none
  uint64_t earlier_tick = 0;
};

class StreamBaseline {
 public:
  uint64_t tick = 0;
  int64_t simulated_ns = 0;
  std::vector<std::shared_ptr<const GridHistory>> objects;  // ascending ids

  const std::shared_ptr<const GridHistory>* find(uint32_t id) const {
    const auto at =
        std::lower_bound(objects.begin(), objects.end(), id,
                         [](const auto& object, uint32_t wanted) { return object->now.object_id < wanted; });
    return at != objects.end() && (*at)->now.object_id == id ? &*at : nullptr;
  }
};

namespace stream_layout {

uint32_t hash_of(const StreamBaseline& baseline);

// Of one object of a frame: how its integers are written.
struct Entry {
  const GridHistory* before = nullptr;  // null: the object is new, or not as it was
  std::shared_ptr<GridHistory> after;
  Prediction prediction = Prediction::Intra;
  std::array<uint8_t, kMaxGridChannels> planes{};
  size_t first_left = 0;  // of its residuals

  size_t count() const { return after->now.count; }
  PredictionSource source(size_t channel, uint64_t tick) const {
    PredictionSource source;
    if (prediction == Prediction::Intra) return source;
    source.last = before->now.values.data() + channel * count();
    if (!before->earlier.empty()) source.earlier = before->earlier.data() + channel * count();
    source.ahead = static_cast<int32_t>(tick - before->tick);
    source.behind = static_cast<int32_t>(before->tick - before->earlier_tick);
    return source;
  }
};

bool same_form(const DriverGrid& a, const DriverGrid& b);
// Whether a straight line through the last two frames may be used; both ends decide it alike.
bool has_line(const GridHistory& before, uint64_t tick);
// Keeps what was, where the next frame may be predicted from it too.
void remember(GridHistory& after, const GridHistory* before);

struct Scratch {
  std::vector<uint32_t> left;
  std::vector<int32_t> last, earlier;
};

// Rotations whose left-out component changed are not predicted: their three integers stand for other things
// now. What is predicted for them is 0. `left_out`: channel 6 of the frame that is written or read.
void forget_turned(const Entry& entry, const int32_t* left_out, size_t channel, Scratch& scratch,
                   PredictionSource& source);

// Calls `visit(entry, channel, plane)` in the order of the bytes: low planes first, equal channels together.
template <class Visit>
void each_plane(const std::vector<Entry>& entries, const Visit& visit) {
  for (int plane = 0; plane < kMaxPlanes; ++plane) {
    for (size_t channel = 0; channel < kMaxGridChannels; ++channel) {
      for (const Entry& entry : entries) {
        if (channel < entry.after->now.channels() && entry.planes[channel] > plane)
          visit(entry, channel, plane);
      }
    }
  }
}

}  // namespace stream_layout
}  // namespace livegs
