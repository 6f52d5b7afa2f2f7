// SPDX-License-Identifier: Apache-2.0
#include <zstd.h>

#include <string>
#include <utility>

#include "core/assert.h"
#include "wire/frame_codec.h"
#include "wire/stream_layout.h"

namespace livegs {

using namespace stream_layout;

namespace {

struct Decompressor {
  ZSTD_DCtx* context = ZSTD_createDCtx();
  ~Decompressor() { ZSTD_freeDCtx(context); }
};

Error bad(const std::string& what) { return invalid_data("stream frame: " + what); }

struct Header {
  uint8_t flags = 0;
  uint64_t tick = 0, gap = 0;  // gap 0: a key frame
  int64_t simulated_ns = 0;
  std::optional<uint32_t> hash;
};

Result<Header> read_header(ByteReader& in) {
  const uint8_t magic = in.read<uint8_t>(), version = in.read<uint8_t>();
  Header header;
  header.flags = in.read<uint8_t>();
  if (in.failed() || magic != kMagic) return bad("does not begin like one");
  if (version != kVersion) {
    return unsupported("stream frame: version " + std::to_string(version) + ", this build reads version " +
                       std::to_string(kVersion) + "; update the older of server and client");
  }
  if ((header.flags & ~(kKeyFrame | kCompressed | kHashed)) != 0) return bad("sets a reserved bit");
  const auto tick = read_varint(in);
  header.simulated_ns = in.read<int64_t>();
  if (!tick) return bad("header is cut short");
  header.tick = *tick;
  if ((header.flags & kKeyFrame) == 0) {
    const auto gap = read_varint(in);
    if (!gap || *gap == 0 || *gap > *tick) return bad("names no frame before it");
    header.gap = *gap;
  }
  if ((header.flags & kHashed) != 0) header.hash = in.read<uint32_t>();
  if (in.failed()) return bad("header is cut short");
  return header;
}

// In `buffer` where it was compressed.
Result<std::span<const std::byte>> read_body(ByteReader& in, std::span<const std::byte> bytes,
                                             bool is_compressed, std::vector<std::byte>& buffer) {
  if (!is_compressed) return bytes.subspan(in.offset());
  const auto size = read_varint(in);
  if (!size || *size > kMaxFrameBytes) return bad("claims a body over the limit");
  const auto rest = bytes.subspan(in.offset());
  // zstd never makes more than about 2^17 bytes of one: what claims more is not tried.
  if (*size > (uint64_t{rest.size()} << 18)) return bad("claims a body that its bytes cannot hold");
  if (buffer.size() < *size) buffer.resize(*size);
  const std::span<std::byte> body = std::span(buffer).first(*size);
  thread_local Decompressor decompressor;
  const size_t made =
      ZSTD_decompressDCtx(decompressor.context, body.data(), body.size(), rest.data(), rest.size());
  if (ZSTD_isError(made) || made != body.size()) return bad("body does not decompress");
  return std::span<const std::byte>(body);
}

// The object's form and how it is written, without its integers.
Result<Entry> read_descriptor(ByteReader& in, uint32_t id, const StreamBaseline* baseline, uint64_t tick) {
  Entry entry;
  const uint8_t how = in.read<uint8_t>();
  const uint8_t mode = how & kModeBits, kind = how >> kKindShift;
  const auto* known = baseline ? baseline->find(id) : nullptr;
  if (known) entry.before = known->get();
  if (mode > static_cast<uint8_t>(Prediction::Linear)) return bad("uses an unknown prediction");
  entry.prediction = static_cast<Prediction>(mode);
  entry.after = std::make_shared<GridHistory>();
  DriverGrid& grid = entry.after->now;
  entry.after->tick = tick;
  if (entry.prediction == Prediction::Intra) {
    grid.revision = in.read<uint8_t>();
    grid.exponent = in.read<int8_t>();
    const auto count = read_varint(in);
    if (in.failed() || !count) return bad("an object is cut short");
    if (kind < static_cast<uint8_t>(DriverKind::Rigid) ||
        kind > static_cast<uint8_t>(DriverKind::Particles)) {
      return bad("object " + std::to_string(id) + " has unknown kind " + std::to_string(kind));
    }
    grid.kind = static_cast<DriverKind>(kind);
    if (grid.exponent < kMinExponent || grid.exponent > kMaxExponent)
      return bad("an object's step is out of range");
    if (grid.revision != 0 && grid.kind != DriverKind::Rigid) return bad("sets a reserved bit");
    if (*count > in.remaining()) return bad("claims " + std::to_string(*count) + " drivers but is cut short");
    grid.count = static_cast<uint32_t>(*count);
  } else {
    if (!entry.before) return bad("predicts object " + std::to_string(id) + ", which was not sent before");
    if (kind != 0) return bad("sets a reserved bit");
    if (entry.prediction == Prediction::Linear && !has_line(*entry.before, tick))
      return bad("predicts from frames that are not there");
    const DriverGrid& was = entry.before->now;
    grid.kind = was.kind;
    grid.revision = was.revision;
    grid.exponent = was.exponent;
    grid.count = was.count;
  }
  grid.object_id = id;
  grid.asleep = (how & kAsleepBit) != 0;
  for (size_t c = 0; c < grid.channels(); c += 2) {
    const uint8_t pair = in.read<uint8_t>();
    entry.planes[c] = pair & 15;
    if (c + 1 < grid.channels()) {
      entry.planes[c + 1] = pair >> 4;
    } else if (pair >> 4 != 0) {
      return bad("sets a reserved bit");
    }
  }
  if (in.failed()) return bad("an object is cut short");
  for (size_t c = 0; c < grid.channels(); ++c) {
    if (entry.planes[c] > kMaxPlanes) return bad("an integer has more than four bytes");
    if (entry.prediction == Prediction::Intra && grid.count > 0 && entry.planes[c] == 0)
      return bad("a new object has no bytes");
  }
  return entry;
}

void add_all_residuals(Entry& entry, uint64_t tick, Scratch& scratch) {
  DriverGrid& grid = entry.after->now;
  const size_t n = entry.count();
  grid.values.resize(grid.channels() * n);
  // What was left out of rotations first: it says which predictions hold.
  for (size_t k = grid.channels(); k-- > 0;) {
    PredictionSource source = entry.source(k, tick);
    forget_turned(entry, grid.channels() > 6 ? grid.values.data() + 6 * n : nullptr, k, scratch, source);
    add_residuals(entry.prediction, source, scratch.left.data() + entry.first_left + k * n, n,
                  grid.values.data() + k * n);
  }
  remember(*entry.after, entry.before);
}

Result<std::vector<uint32_t>> read_gone(ByteReader& in, uint64_t count, const StreamBaseline* baseline) {
  std::vector<uint32_t> gone;
  if (count > in.remaining()) return bad("is cut short");
  uint64_t id = 0;
  for (uint64_t i = 0; i < count; ++i) {
    const auto step = read_varint(in);
    if (!step || (i > 0 && *step == 0) || *step > UINT32_MAX || (id += *step) > UINT32_MAX)
      return bad("lists ids out of order");
    if (!baseline || !baseline->find(static_cast<uint32_t>(id)))
      return bad("takes away an object that is not there");
    gone.push_back(static_cast<uint32_t>(id));
  }
  return gone;
}

// The objects of the frame after it, from those before and those that are in it.
std::vector<std::shared_ptr<const GridHistory>> joined(const StreamBaseline* baseline,
                                                       const std::vector<uint32_t>& gone,
                                                       const std::vector<Entry>& entries) {
  std::vector<std::shared_ptr<const GridHistory>> objects;
  size_t next = 0;
  if (baseline) {
    for (const auto& object : baseline->objects) {
      const uint32_t id = object->now.object_id;
      for (; next < entries.size() && entries[next].after->now.object_id < id; ++next)
        objects.push_back(entries[next].after);
      const bool renewed = next < entries.size() && entries[next].after->now.object_id == id;
      if (renewed) objects.push_back(entries[next++].after);
      if (!renewed && !std::binary_search(gone.begin(), gone.end(), id)) objects.push_back(object);
    }
  }
  for (; next < entries.size(); ++next) objects.push_back(entries[next].after);
  return objects;
}

Result<StreamBaselinePtr> read_frame(std::span<const std::byte> bytes, const StreamBaseline* baseline) {
  if (bytes.size() > kMaxFrameBytes)
    return Error{ErrorCode::TooLarge,
                 "stream frame: over the limit of " + std::to_string(kMaxFrameBytes) + " bytes"};
  ByteReader in(bytes);
  const auto header = read_header(in);
  if (!header) return header.error();
  if (header->gap == 0) baseline = nullptr;
  if (header->gap > 0 && (!baseline || baseline->tick != header->tick - header->gap)) {
    return Error{ErrorCode::Unavailable, "stream frame: follows frame " +
                                             std::to_string(header->tick - header->gap) +
                                             ", which was not read; ask for a key frame"};
  }
  thread_local std::vector<std::byte> buffer;
  const auto body = read_body(in, bytes, (header->flags & kCompressed) != 0, buffer);
  if (!body) return body.error();

  ByteReader parts(*body);
  const auto entry_count = read_varint(parts), gone_count = read_varint(parts);
  if (!entry_count || !gone_count || *entry_count > parts.remaining()) return bad("is cut short");
  const auto gone = read_gone(parts, *gone_count, baseline);
  if (!gone) return gone.error();
  std::vector<Entry> entries;
  uint64_t id = 0, integers = 0, plane_bytes = 0;
  for (uint64_t i = 0; i < *entry_count; ++i) {
    const auto step = read_varint(parts);
    if (!step || (i > 0 && *step == 0) || *step > UINT32_MAX || (id += *step) > UINT32_MAX)
      return bad("lists ids out of order");
    auto entry = read_descriptor(parts, static_cast<uint32_t>(id), baseline, header->tick);
    if (!entry) return entry.error();
    entry->first_left = integers;
    integers += entry->after->now.channels() * entry->count();
    for (size_t c = 0; c < entry->after->now.channels(); ++c)
      plane_bytes += entry->planes[c] * entry->count();
    entries.push_back(std::move(*entry));
  }
  if (plane_bytes != parts.remaining()) return bad("holds fewer or more bytes than its objects need");

  thread_local Scratch scratch;
  scratch.left.assign(integers, 0);
  size_t at = parts.offset();
  each_plane(entries, [&](const Entry& entry, size_t channel, int plane) {
    read_plane(body->data() + at, entry.count(), plane,
               scratch.left.data() + entry.first_left + channel * entry.count());
    at += entry.count();
  });
  for (Entry& entry : entries) add_all_residuals(entry, header->tick, scratch);
  auto next = std::make_shared<StreamBaseline>();
  next->tick = header->tick;
  next->simulated_ns = header->simulated_ns;
  next->objects = joined(baseline, *gone, entries);
  if (header->hash && *header->hash != hash_of(*next))
    return bad("this end is not as the other expects it; ask for a key frame");
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
