// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "wire/driver_grid.h"
#include "wire/grid_coder.h"
#include "wire/header.h"
#include "wire/little_endian.h"
#include "wire/varint.h"

// Shared internals of the writer and the reader of stream frames. See proto/frame_format.md, "Streams".

namespace livegs {

namespace stream_layout {
inline constexpr MessageHeader<uint8_t, uint8_t> kHeader{"stream frame", " with 0xD6", 0xD6, 2};
inline constexpr uint8_t kKeyframe = 1, kHashed = 4;
inline constexpr int32_t kMaxGap = 16;  // maximum ticks of a linear extrapolation
inline constexpr int kMinExponent = -30, kMaxExponent = 30;
// Rice parameters of object counts, of steps between ids and of driver counts.
inline constexpr int kObjectCountBits = 4, kIdBits = 1, kDriverCountBits = 2;

}  // namespace stream_layout

// One object as stored by the reader, and its integers in its own earlier frames, in the same form.
struct GridHistory {
  DriverGrid now;
  uint64_t tick = 0;
  GridValues earlier, earliest;  // empty: none
  uint64_t earlier_tick = 0, earliest_tick = 0;
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

// Whether linear prediction from the last two frames, or a curve through the last three, may be used. Both
// ends apply the same rule.
bool has_line(const GridHistory& before, uint64_t tick);
bool has_curve(const GridHistory& before, uint64_t tick);
// Stores the previous values if the next frame may be predicted from them.
void remember(GridHistory& after, const GridHistory* before);
// The frames to predict from; null: none.
GridPast past_of(const GridHistory* before, uint64_t tick);

// Storage for the objects of one frame. Small bodies share an allocation, because each one costs as much as
// the integers of a body. A body that no longer moves keeps only its own small group alive.
class HistoryPlaces {
 public:
  std::shared_ptr<GridHistory> take(size_t drivers);

 private:
  static constexpr size_t kTogether = 16, kFewDrivers = 1;
  std::shared_ptr<GridHistory[]> together_;
  size_t taken_ = kTogether;
};

}  // namespace stream_layout
}  // namespace livegs
