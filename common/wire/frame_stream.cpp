// SPDX-License-Identifier: Apache-2.0
// The layout is proto/frame_format.md, "Streams".
#include "wire/frame_stream.h"

#include <zstd.h>

#include <algorithm>
#include <utility>

#include "core/assert.h"
#include "wire/frame_codec.h"
#include "wire/stream_layout.h"

namespace livegs {

using namespace stream_layout;

namespace {

Prediction choose(const Entry& entry, uint64_t tick) {
  if (!entry.before || !same_form(entry.before->now, entry.after->now)) return Prediction::Intra;
  if (!has_line(*entry.before, tick)) return Prediction::Last;
  Entry linear = entry;
  linear.prediction = Prediction::Linear;
  uint64_t by_last = 0, by_line = 0;
  for (size_t c = 0; c < 3; ++c) {
    const PredictionCost cost = prediction_cost(
        linear.source(c, tick), entry.after->now.values.data() + c * entry.count(), entry.count());
    by_last += cost.last;
    by_line += cost.linear;
  }
  return by_line < by_last ? Prediction::Linear : Prediction::Last;
}

void write_descriptor(ByteWriter& out, const Entry& entry, uint32_t id_step) {
  const DriverGrid& grid = entry.after->now;
  const bool intra = entry.prediction == Prediction::Intra;
  write_varint(out, id_step);
  out.write(static_cast<uint8_t>(static_cast<uint8_t>(entry.prediction) | (grid.asleep ? kAsleepBit : 0) |
                                 (intra ? static_cast<uint8_t>(grid.kind) << kKindShift : 0)));
  if (intra) {
    out.write(static_cast<uint8_t>(grid.revision));
    out.write(static_cast<int8_t>(grid.exponent));
    write_varint(out, grid.count);
  }
  for (size_t c = 0; c < grid.channels(); c += 2) {
    out.write(
        static_cast<uint8_t>(entry.planes[c] | (c + 1 < grid.channels() ? entry.planes[c + 1] << 4 : 0)));
  }
}

struct Compressor {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ~Compressor() { ZSTD_freeCCtx(context); }
};

// Buffers that are kept: fresh ones of this size cost more than what is done with them.
struct Buffers {
  Scratch scratch;
  std::vector<std::byte> raw, packed;
};

// Empty where it would not be smaller.
std::span<const std::byte> compressed(std::span<const std::byte> raw, std::vector<std::byte>& packed) {
  if (raw.size() < kWorthCompressing) return {};
  thread_local Compressor compressor;
  if (packed.size() < ZSTD_compressBound(raw.size())) packed.resize(ZSTD_compressBound(raw.size()));
  const size_t size =
      ZSTD_compressCCtx(compressor.context, packed.data(), packed.size(), raw.data(), raw.size(), kLevel);
  if (ZSTD_isError(size) || size >= raw.size()) return {};
  return std::span(packed).first(size);
}

void take_all_residuals(std::vector<Entry>& entries, uint64_t tick, Scratch& scratch) {
  size_t total = 0;
  for (Entry& entry : entries) {
    entry.first_left = total;
    total += entry.after->now.values.size();
  }
  scratch.left.resize(total);
  for (Entry& entry : entries) {
    const DriverGrid& grid = entry.after->now;
    entry.prediction = choose(entry, tick);
    for (size_t c = 0; c < grid.channels(); ++c) {
      PredictionSource source = entry.source(c, tick);
      const int32_t* const left_out = grid.channels() > 6 ? grid.values.data() + 6 * entry.count() : nullptr;
      forget_turned(entry, left_out, c, scratch, source);
      const int planes =
          take_residuals(entry.prediction, source, grid.values.data() + c * entry.count(), entry.count(),
                         scratch.left.data() + entry.first_left + c * entry.count());
      // A new object's drivers take a byte each at least, so that a few bytes cannot claim millions.
      const int least = entry.prediction == Prediction::Intra && entry.count() > 0 ? 1 : 0;
      entry.planes[c] = static_cast<uint8_t>(std::max(planes, least));
    }
  }
}

}  // namespace

uint64_t tick_of(const StreamBaseline& baseline) { return baseline.tick; }

bool same_state(const StreamBaseline& a, const StreamBaseline& b) {
  // From what did not move for so long no straight line is drawn any more: when it came does not matter.
  const auto rests = [&](const GridHistory& object) { return a.tick - object.tick >= kMaxGap; };
  const auto alike = [&](const auto& one, const auto& other) {
    if (one == other) return true;  // both streams were sent it in one frame
    return one->now == other->now && ((rests(*one) && rests(*other)) ||
                                      (one->tick == other->tick && one->earlier_tick == other->earlier_tick &&
                                       one->earlier == other->earlier));
  };
  return a.tick == b.tick && std::equal(a.objects.begin(), a.objects.end(), b.objects.begin(), b.objects.end(), alike);
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
  std::vector<Entry> entries;
  for (const ObjectDrivers* object : ordered) {
    const auto* known = baseline ? baseline->find(object->object_id) : nullptr;
    if (known && (*known)->now.revision == object->revision && options.leave_out &&
        options.leave_out(object->object_id)) {
      next->objects.push_back(*known);
      continue;
    }
    auto after = std::make_shared<GridHistory>();
    after->now = to_grid(*object, known ? &(*known)->now : nullptr, options.precision);
    after->tick = frame.tick;
    if (known && after->now == (*known)->now) {
      next->objects.push_back(*known);
      continue;
    }
    Entry entry;
    entry.before = known ? known->get() : nullptr;
    remember(*after, entry.before);
    entry.after = after;
    next->objects.push_back(std::move(after));
    entries.push_back(std::move(entry));
  }
  std::vector<uint32_t> gone;
  if (baseline) {
    for (const auto& object : baseline->objects) {
      if (!next->find(object->now.object_id)) gone.push_back(object->now.object_id);
    }
  }

  thread_local Buffers buffers;
  Scratch& scratch = buffers.scratch;
  take_all_residuals(entries, frame.tick, scratch);
  ByteWriter head;
  write_varint(head, entries.size());
  write_varint(head, gone.size());
  uint32_t last_id = 0;
  for (const uint32_t id : gone) write_varint(head, id - std::exchange(last_id, id));
  last_id = 0;
  size_t plane_bytes = 0;
  for (const Entry& entry : entries) {
    const uint32_t id = entry.after->now.object_id;
    write_descriptor(head, entry, id - std::exchange(last_id, id));
    for (size_t c = 0; c < entry.after->now.channels(); ++c) plane_bytes += entry.planes[c] * entry.count();
  }
  const std::vector<std::byte> front = std::move(head).take();
  std::vector<std::byte>& raw = buffers.raw;
  raw.resize(front.size() + plane_bytes);
  std::copy(front.begin(), front.end(), raw.begin());
  size_t at = front.size();
  each_plane(entries, [&](const Entry& entry, size_t channel, int plane) {
    write_plane(scratch.left.data() + entry.first_left + channel * entry.count(), entry.count(), plane,
                raw.data() + at);
    at += entry.count();
  });

  // By ticks alone, so that streams with the same state take the same bytes.
  const bool hashed = options.hash_interval > 0 &&
                      (!baseline || frame.tick / options.hash_interval != baseline->tick / options.hash_interval);
  const std::span<const std::byte> packed = compressed(raw, buffers.packed);
  const std::span<const std::byte> body = packed.empty() ? raw : packed;
  ByteWriter out;
  out.reserve(body.size() + 40);
  out.write(kMagic);
  out.write(kVersion);
  out.write(static_cast<uint8_t>((baseline ? 0 : kKeyFrame) | (packed.empty() ? 0 : kCompressed) |
                                 (hashed ? kHashed : 0)));
  write_varint(out, frame.tick);
  out.write(frame.simulated_ns);
  if (baseline) write_varint(out, frame.tick - baseline->tick);
  if (hashed) out.write(hash_of(*next));
  if (!packed.empty()) write_varint(out, raw.size());
  EncodedStreamFrame encoded;
  encoded.bytes = std::move(out).take();
  encoded.bytes.insert(encoded.bytes.end(), body.begin(), body.end());
  LIVEGS_ASSERT(encoded.bytes.size() <= kMaxFrameBytes && raw.size() <= kMaxFrameBytes);
  encoded.object_count = entries.size();
  encoded.next = std::move(next);
  return encoded;
}

}  // namespace livegs
