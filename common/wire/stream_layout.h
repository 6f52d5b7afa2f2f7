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

// What writing and reading a frame of a stream have in common; proto/frame_format.md, "Streams". For these
// two alone.

namespace livegs {

namespace stream_layout {
inline constexpr MessageHeader<uint8_t, uint8_t> kHeader{"stream frame", " like one", 0xD6, 2};
inline constexpr uint8_t kKeyFrame = 1, kHashed = 4;
inline constexpr int32_t kMaxGap = 16;  // ticks over which a straight line is believed
inline constexpr int kMinExponent = -30, kMaxExponent = 30;
// Low bits of the codes of numbers of objects, of steps between ids, of driver counts.
inline constexpr int kObjectCountBits = 4, kIdBits = 1, kDriverCountBits = 2;

}  // namespace stream_layout

// One object as the reader has it, and its integers in the frames of its own before, in the same form.
struct GridHistory {
  DriverGrid now;
  uint64_t tick = 0;
  GridValues earlier, earliest;  // empty: there are none
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

// Whether a straight line through the last two frames may be used, and a curve through the last three; both
// ends decide it alike.
bool has_line(const GridHistory& before, uint64_t tick);
bool has_curve(const GridHistory& before, uint64_t tick);
// Keeps what was, where the next frame may be predicted from it too.
void remember(GridHistory& after, const GridHistory* before);
// What there is to predict from; null: nothing.
GridPast past_of(const GridHistory* before, uint64_t tick);

// Places for the objects of one frame. Few bodies share a piece of memory, of which each costs as much as a
// body's integers; no more than these stay because of one that moves no more.
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
