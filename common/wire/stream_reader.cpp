// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <utility>

#include "core/assert.h"
#include "wire/frame_codec.h"
#include "wire/frame_stream.h"
#include "wire/stream_layout.h"

namespace livegs {

using namespace stream_layout;

namespace {

Error bad(const std::string& what) { return kHeader.invalid(what); }

struct Header {
  uint8_t flags = 0;
  uint64_t tick = 0, gap = 0;  // gap 0: a keyframe
  int64_t simulated_ns = 0;
  std::optional<uint32_t> hash;
};

Result<Header> read_header(ByteReader& in) {
  const uint8_t magic = in.read<uint8_t>(), version = in.read<uint8_t>();
  Header header;
  header.flags = in.read<uint8_t>();
  if (auto known = kHeader.check(magic, version, in.failed()); !known) return known.error();
  if ((header.flags & ~(kKeyframe | kHashed)) != 0) return bad("sets a reserved bit");
  const auto tick = read_varint(in);
  header.simulated_ns = in.read<int64_t>();
  if (!tick) return bad("header is truncated");
  header.tick = *tick;
  if ((header.flags & kKeyframe) == 0) {
    const auto gap = read_varint(in);
    if (!gap || *gap == 0 || *gap > *tick) return bad("has an invalid predecessor");
    header.gap = *gap;
  }
  if ((header.flags & kHashed) != 0) header.hash = in.read<uint32_t>();
  if (in.failed()) return bad("header is truncated");
  return header;
}

// Buffers that are reused: allocating them for each frame costs more than the work itself.
struct Buffers {
  std::vector<std::byte> body;
  GridScratch scratch;
};

// Ascending ids, each coded as the step from the one before.
class IdReader {
 public:
  std::optional<uint32_t> next(RiceReader& bits) {
    const uint64_t step = bits.code(0, kIdBits);
    if ((begun_ && step == 0) || (id_ += step) > UINT32_MAX) return std::nullopt;
    begun_ = true;
    return static_cast<uint32_t>(id_);
  }

 private:
  uint64_t id_ = 0;
  bool begun_ = false;
};

// Form of a new object. Counts are checked against the available bits before any allocation.
Result<DriverGrid> read_form(RiceReader& bits) {
  DriverGrid grid;
  const uint32_t kind = bits.bits(0, 2);
  grid.revision = bits.bits(0, 8);
  grid.exponent = static_cast<int8_t>(bits.bits(0, 8));
  grid.count = bits.code(0, kDriverCountBits);
  if (kind < static_cast<uint32_t>(DriverKind::Rigid)) return bad("an object has unknown kind 0");
  grid.kind = static_cast<DriverKind>(kind);
  if (grid.exponent < kMinExponent || grid.exponent > kMaxExponent)
    return bad("the step of an object is out of range");
  if (grid.revision != 0 && grid.kind != DriverKind::Rigid) return bad("sets a reserved bit");
  const bool has_coordinates = grid.kind == DriverKind::Lattice && bits.bits(0, 1) != 0;
  if (bits.failed() || grid.count > bits.remaining_bits() / kMinIntraDriverBits)
    return bad("claims " + std::to_string(grid.count) + " drivers but is truncated");
  if (!has_coordinates) return grid;
  std::vector<Eigen::Vector3i> coordinates(grid.count);
  if (!code_coordinates(bits, coordinates)) return bad("an object is truncated");
  grid.neighbours = find_node_neighbours(std::move(coordinates));
  if (!grid.neighbours) return bad("the coordinates of a node are out of range");
  if (grid.count > bits.remaining_bits() / kMinIntraDriverBits) return bad("an object is truncated");
  return grid;
}

int32_t read_weight(RiceReader& bits) {
  const auto raw = static_cast<int32_t>(bits.bits(0, kWeightBits));
  return raw >= 1 << (kWeightBits - 1) ? raw - (1 << kWeightBits) : raw;
}

Result<std::shared_ptr<GridHistory>> read_object(RiceReader& bits, GridScratch& scratch, uint32_t id,
                                                 const StreamBaseline* baseline, uint64_t tick,
                                                 HistoryPlaces& places, GridScales& scales) {
  const auto prediction = static_cast<Prediction>(bits.bits(0, 2));
  const bool asleep = bits.bits(0, 1) != 0;
  const auto* known = baseline ? baseline->find(id) : nullptr;
  const GridHistory* const before = known ? known->get() : nullptr;
  DriverGrid grid;
  GridPast past;
  if (prediction == Prediction::Intra) {
    auto form = read_form(bits);
    if (!form) return form.error();
    grid = std::move(*form);
  } else {
    if (!before) return bad("predicts object " + std::to_string(id) + ", which was not sent before");
    if ((prediction == Prediction::Linear && !has_line(*before, tick)) ||
        (prediction == Prediction::Curve && !has_curve(*before, tick))) {
      return bad("predicts from frames that were not sent");
    }
    past = past_of(before, tick);
    const DriverGrid& was = before->now;
    grid.kind = was.kind;
    grid.revision = was.revision;
    grid.exponent = was.exponent;
    grid.count = was.count;
    grid.neighbours = was.neighbours;
    if (prediction == Prediction::Curve && grid.neighbours) {
      past.weight_v = read_weight(bits);
      past.weight_a = read_weight(bits);
    }
  }
  grid.object_id = id;
  grid.asleep = asleep;
  grid.values = GridValues(grid.channels() * grid.count);
  if (!code_values(bits, grid, prediction, past, scales, scratch) || bits.failed())
    return bad("an object is truncated");
  std::shared_ptr<GridHistory> after = places.take(grid.count);
  after->now = std::move(grid);
  after->tick = tick;
  remember(*after, before);
  return after;
}

Result<std::vector<uint32_t>> read_gone(RiceReader& bits, uint32_t count, const StreamBaseline* baseline) {
  std::vector<uint32_t> gone;
  IdReader ids;
  if (count > bits.remaining_bits()) return bad("is truncated");
  for (uint32_t i = 0; i < count; ++i) {
    const auto id = ids.next(bits);
    if (!id || bits.failed()) return bad("lists ids out of order");
    if (!baseline || !baseline->find(*id)) return bad("removes an object that does not exist");
    gone.push_back(*id);
  }
  return gone;
}

// The objects after the frame: those before it, updated by those in it.
std::vector<std::shared_ptr<const GridHistory>> joined(
    const StreamBaseline* baseline, const std::vector<uint32_t>& gone,
    const std::vector<std::shared_ptr<GridHistory>>& entries) {
  std::vector<std::shared_ptr<const GridHistory>> objects;
  objects.reserve((baseline ? baseline->objects.size() : 0) + entries.size());
  size_t next = 0;
  if (baseline) {
    for (const auto& object : baseline->objects) {
      const uint32_t id = object->now.object_id;
      for (; next < entries.size() && entries[next]->now.object_id < id; ++next)
        objects.push_back(entries[next]);
      const bool renewed = next < entries.size() && entries[next]->now.object_id == id;
      if (renewed) objects.push_back(entries[next++]);
      if (!renewed && !std::binary_search(gone.begin(), gone.end(), id)) objects.push_back(object);
    }
  }
  for (; next < entries.size(); ++next) objects.push_back(entries[next]);
  return objects;
}

Result<StreamBaselinePtr> read_frame(std::span<const std::byte> bytes, const StreamBaseline* baseline) {
  if (bytes.size() > kMaxFrameBytes)
    return Error{ErrorCode::TooLarge,
                 "stream frame: larger than the limit of " + std::to_string(kMaxFrameBytes) + " bytes"};
  ByteReader in(bytes);
  const auto header = read_header(in);
  if (!header) return header.error();
  if (header->gap == 0) baseline = nullptr;
  if (header->gap > 0 && (!baseline || baseline->tick != header->tick - header->gap)) {
    return Error{ErrorCode::Unavailable, "stream frame: the predecessor, frame " +
                                             std::to_string(header->tick - header->gap) +
                                             ", was not read; request a keyframe"};
  }
  thread_local Buffers buffers;
  RiceReader bits(buffers.body, bytes.subspan(in.offset()));
  const uint32_t entry_count = bits.code(0, kObjectCountBits), gone_count = bits.code(0, 0);
  const auto gone = read_gone(bits, gone_count, baseline);
  if (!gone) return gone.error();
  std::vector<std::shared_ptr<GridHistory>> entries;
  IdReader ids;
  HistoryPlaces places;
  GridScales scales;
  for (uint32_t i = 0; i < entry_count; ++i) {
    const auto id = ids.next(bits);
    if (!id) return bad("lists ids out of order");
    if (bits.failed()) return bad("is truncated");
    auto entry = read_object(bits, buffers.scratch, *id, baseline, header->tick, places, scales);
    if (!entry) return entry.error();
    entries.push_back(std::move(*entry));
  }
  if (!bits.at_end()) return bad("the number of bits does not match its objects");
  auto next = std::make_shared<StreamBaseline>();
  next->tick = header->tick;
  next->simulated_ns = header->simulated_ns;
  next->objects = joined(baseline, *gone, entries);
  if (header->hash && *header->hash != hash_of(*next))
    return bad("the hash of the reader state is wrong; request a keyframe");
  return StreamBaselinePtr(std::move(next));
}

}  // namespace

Result<int64_t> stream_frame_time_ns(std::span<const std::byte> bytes) {
  ByteReader in(bytes);
  const auto header = read_header(in);
  if (!header) return header.error();
  return header->simulated_ns;
}

Result<DriverFrame> StreamReader::read(std::span<const std::byte> bytes) {
  auto next = read_frame(bytes, baseline_.get());
  failed_ = !next;
  if (!next) return next.error();
  baseline_ = std::move(*next);
  return frame_of(*baseline_);
}

}  // namespace livegs
