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
    const std::vector<int32_t>& v = grid.values;
    size_t i = 0;
    for (; i + 1 < v.size(); i += 2)
      hash.add(uint64_t{static_cast<uint32_t>(v[i])} << 32 | static_cast<uint32_t>(v[i + 1]));
    if (i < v.size()) hash.add(static_cast<uint32_t>(v[i]));
  }
  return hash.value();
}

bool same_form(const DriverGrid& a, const DriverGrid& b) {
  return a.kind == b.kind && a.count == b.count && a.revision == b.revision && a.exponent == b.exponent;
}

bool has_line(const GridHistory& before, uint64_t tick) {
  return !before.earlier.empty() && tick > before.tick && tick - before.tick <= kMaxGap &&
         before.tick - before.earlier_tick <= kMaxGap;
}

void remember(GridHistory& after, const GridHistory* before) {
  if (!before || !same_form(before->now, after.now)) return;
  after.earlier = before->now.values;
  after.earlier_tick = before->tick;
}

void forget_turned(const Entry& entry, const int32_t* left_out, size_t channel, Scratch& scratch,
                   PredictionSource& source) {
  if (entry.prediction == Prediction::Intra || channel < 3 || channel > 5 ||
      entry.after->now.kind == DriverKind::Lattice)
    return;
  const size_t n = entry.count();
  const int32_t* const was = entry.before->now.values.data() + 6 * n;
  if (std::equal(left_out, left_out + n, was) &&
      (!source.earlier || std::equal(left_out, left_out + n, entry.before->earlier.data() + 6 * n))) {
    return;
  }
  std::vector<int32_t>&last = scratch.last, &earlier = scratch.earlier;
  last.assign(source.last, source.last + n);
  earlier.assign(n, 0);
  if (source.earlier) earlier.assign(source.earlier, source.earlier + n);
  const int32_t* const before_that = source.earlier ? entry.before->earlier.data() + 6 * n : was;
  for (size_t i = 0; i < n; ++i) {
    if (left_out[i] != was[i]) last[i] = earlier[i] = 0;
    if (left_out[i] != before_that[i]) earlier[i] = last[i];
  }
  source.last = last.data();
  source.earlier = earlier.data();
}

}  // namespace livegs::stream_layout
