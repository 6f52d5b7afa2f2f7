// SPDX-License-Identifier: Apache-2.0
// The layout is proto/frame_format.md, "Streams". The number of a frame is its tick (skin/driver_frame.h).
#include "wire/frame_stream.h"

#include <algorithm>
#include <utility>

#include "core/assert.h"
#include "wire/frame_codec.h"
#include "wire/stream_layout.h"

namespace livegs {

using namespace stream_layout;

namespace {

// Buffers that are reused: allocating them for each frame costs more than the work itself.
struct Buffers {
  std::vector<std::byte> body;
  GridScratch scratch;
};

// An object of the frame.
struct Entry {
  const GridHistory* before;  // null: new, or in another form than before
  GridHistory* after;
};

Prediction choose(const Entry& entry, GridPast& past) {
  const DriverGrid& grid = entry.after->now;
  if (!entry.before || !same_form(entry.before->now, grid)) return Prediction::Intra;
  const bool linear = has_line(*entry.before, entry.after->tick),
             curve = has_curve(*entry.before, entry.after->tick);
  if (curve && grid.neighbours) {
    fit_curve(grid, past);
    return Prediction::Curve;
  }
  if (!linear) return Prediction::Last;
  const PredictionCosts costs = prediction_costs(grid, past, linear, curve);
  if (costs.curve < std::min(costs.last, costs.linear)) return Prediction::Curve;
  return costs.linear < costs.last ? Prediction::Linear : Prediction::Last;
}

void write_object(RiceWriter& bits, const Entry& entry, uint32_t id_step, GridScales& scales,
                  GridScratch& scratch) {
  DriverGrid& grid = entry.after->now;
  GridPast past = past_of(entry.before, entry.after->tick);
  const Prediction prediction = choose(entry, past);
  bits.code(id_step, kIdBits);
  bits.bits(static_cast<uint32_t>(prediction), 2);
  bits.bits(grid.asleep ? 1 : 0, 1);
  if (prediction == Prediction::Intra) {
    bits.bits(static_cast<uint32_t>(grid.kind), 2);
    bits.bits(grid.revision, 8);
    bits.bits(static_cast<uint8_t>(grid.exponent), 8);
    bits.code(grid.count, kDriverCountBits);
    if (grid.kind == DriverKind::Lattice) bits.bits(grid.neighbours ? 1 : 0, 1);
    if (grid.neighbours) {
      std::vector<Eigen::Vector3i> coordinates = grid.neighbours->coordinates;
      code_coordinates(bits, coordinates);
    }
  } else if (prediction == Prediction::Curve && grid.neighbours) {
    for (const int32_t weight : {past.weight_v, past.weight_a})
      bits.bits(static_cast<uint32_t>(weight) & ((1u << kWeightBits) - 1), kWeightBits);
  }
  code_values(bits, grid, prediction, past, scales, scratch);
}

}  // namespace

uint64_t tick_of(const StreamBaseline& baseline) { return baseline.tick; }

bool same_state(const StreamBaseline& a, const StreamBaseline& b) {
  // Linear prediction is not used after such a long rest, so the time of the last frame does not matter.
  const auto rests = [&](const GridHistory& object) { return a.tick - object.tick >= kMaxGap; };
  const auto alike = [&](const auto& one, const auto& other) {
    if (one == other) return true;  // both streams received it in the same frame
    return one->now == other->now && ((rests(*one) && rests(*other)) ||
                                      (one->tick == other->tick && one->earlier_tick == other->earlier_tick &&
                                       one->earliest_tick == other->earliest_tick &&
                                       one->earlier == other->earlier && one->earliest == other->earliest));
  };
  return a.tick == b.tick &&
         std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(), alike);
}

DriverFrame frame_of(const StreamBaseline& baseline) {
  DriverFrame frame;
  frame.tick = baseline.tick;
  frame.simulated_ns = baseline.simulated_ns;
  frame.objects.reserve(baseline.objects.size());
  for (const auto& object : baseline.objects) frame.objects.push_back(from_grid(object->now));
  return frame;
}

EncodedStreamFrame encode_stream_frame(const DriverFrame& frame, const StreamBaselinePtr& baseline,
                                       const StreamOptions& options) {
  LIVEGS_ASSERT(!baseline || frame.tick > baseline->tick);
  std::vector<const ObjectDrivers*> ordered;
  for (const ObjectDrivers& object : frame.objects) ordered.push_back(&object);
  std::sort(ordered.begin(), ordered.end(),
            [](const auto* a, const auto* b) { return a->object_id < b->object_id; });

  auto next = std::make_shared<StreamBaseline>();
  next->tick = frame.tick;
  next->simulated_ns = frame.simulated_ns;
  next->objects.reserve(ordered.size());
  HistoryPlaces places;
  std::vector<Entry> entries;
  entries.reserve(ordered.size());
  size_t codes = 8;
  for (const ObjectDrivers* object : ordered) {
    const auto* known = baseline ? baseline->find(object->object_id) : nullptr;
    if (known && (*known)->now.revision == object->revision && options.leave_out &&
        options.leave_out(object->object_id)) {
      next->objects.push_back(*known);
      continue;
    }
    DriverGrid grid = to_grid(*object, known ? &(*known)->now : nullptr, options.precision);
    if (!options.send_neighbours) grid.neighbours = nullptr;
    if (known && grid == (*known)->now) {
      next->objects.push_back(*known);
      continue;
    }
    auto after = places.take(grid.count);
    after->now = std::move(grid);
    after->tick = frame.tick;
    remember(*after, known ? known->get() : nullptr);
    entries.push_back({known ? known->get() : nullptr, after.get()});
    codes += 12 + 2 * after->now.values.size() + after->now.count;
    next->objects.push_back(std::move(after));
  }
  std::vector<uint32_t> gone;
  if (baseline) {
    for (const auto& object : baseline->objects) {
      if (!next->find(object->now.object_id)) gone.push_back(object->now.object_id);
    }
  }

  thread_local Buffers buffers;
  RiceWriter bits(buffers.body, codes + gone.size());
  bits.code(static_cast<uint32_t>(entries.size()), kObjectCountBits);
  bits.code(static_cast<uint32_t>(gone.size()), 0);
  uint32_t last_id = 0;
  for (const uint32_t id : gone) bits.code(id - std::exchange(last_id, id), kIdBits);
  last_id = 0;
  GridScales scales;
  for (const Entry& entry : entries) {
    const uint32_t id = entry.after->now.object_id;
    write_object(bits, entry, id - std::exchange(last_id, id), scales, buffers.scratch);
  }
  const std::span<const std::byte> body = bits.written();

  // Depends only on ticks, so that streams with the same state get the same bytes.
  const bool hashed = options.hash_interval > 0 && (!baseline || frame.tick / options.hash_interval !=
                                                                     baseline->tick / options.hash_interval);
  ByteWriter out;
  out.reserve(body.size() + 40);
  kHeader.write(out);
  out.write(static_cast<uint8_t>((baseline ? 0 : kKeyframe) | (hashed ? kHashed : 0)));
  write_varint(out, frame.tick);
  out.write(frame.simulated_ns);
  if (baseline) write_varint(out, frame.tick - baseline->tick);
  if (hashed) out.write(hash_of(*next));
  EncodedStreamFrame encoded;
  encoded.bytes = std::move(out).take();
  encoded.bytes.insert(encoded.bytes.end(), body.begin(), body.end());
  LIVEGS_ASSERT(encoded.bytes.size() <= kMaxFrameBytes);
  encoded.object_count = entries.size();
  encoded.next = std::move(next);
  return encoded;
}

}  // namespace livegs
