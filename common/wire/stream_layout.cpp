// SPDX-License-Identifier: Apache-2.0
#include "wire/stream_layout.h"

#include "wire/word_hash.h"

namespace livegs::stream_layout {

uint32_t hash_of(const StreamBaseline& baseline) {
  WordHash hash;
  hash.add(baseline.tick);
  for (const auto& object : baseline.objects) {
    const DriverGrid& grid = object->now;
    hash.add(uint64_t{grid.object_id} << 32 | grid.revision << 16 | static_cast<uint64_t>(grid.kind) << 8 |
             (grid.asleep ? 1u : 0u));
    hash.add(uint64_t{grid.count} << 32 | static_cast<uint32_t>(grid.exponent));
    const int32_t* const v = grid.values.data();
    const size_t count = grid.values.size();
    size_t i = 0;
    for (; i + 1 < count; i += 2)
      hash.add(uint64_t{static_cast<uint32_t>(v[i])} << 32 | static_cast<uint32_t>(v[i + 1]));
    if (i < count) hash.add(static_cast<uint32_t>(v[i]));
  }
  return hash.value();
}

bool has_line(const GridHistory& before, uint64_t tick) {
  return !before.earlier.empty() && tick > before.tick && tick - before.tick <= kMaxGap &&
         before.tick - before.earlier_tick <= kMaxGap;
}

bool has_curve(const GridHistory& before, uint64_t tick) {
  return !before.earliest.empty() && has_line(before, tick) &&
         tick - before.tick == before.tick - before.earlier_tick &&
         tick - before.tick == before.earlier_tick - before.earliest_tick;
}

void remember(GridHistory& after, const GridHistory* before) {
  if (!before || !same_form(before->now, after.now)) return;
  after.earlier = before->now.values;
  after.earlier_tick = before->tick;
  after.earliest = before->earlier;
  after.earliest_tick = before->earlier_tick;
}

GridPast past_of(const GridHistory* before, uint64_t tick) {
  GridPast past;
  if (!before) return past;
  past.last = before->now.values.data();
  if (!before->earlier.empty()) past.earlier = before->earlier.data();
  if (!before->earliest.empty()) past.earliest = before->earliest.data();
  if (has_line(*before, tick)) {
    past.ahead = static_cast<int32_t>(tick - before->tick);
    past.behind = static_cast<int32_t>(before->tick - before->earlier_tick);
  }
  return past;
}

std::shared_ptr<GridHistory> HistoryPlaces::take(size_t drivers) {
  if (drivers > kFewDrivers) return std::make_shared<GridHistory>();
  if (taken_ == kTogether) {
    together_ = std::make_shared<GridHistory[]>(kTogether);
    taken_ = 0;
  }
  return std::shared_ptr<GridHistory>(together_, &together_[static_cast<std::ptrdiff_t>(taken_++)]);
}

}  // namespace livegs::stream_layout
