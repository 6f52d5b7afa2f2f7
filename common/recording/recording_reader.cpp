// SPDX-License-Identifier: Apache-2.0
// The layout is proto/recording_format.md.
#include "recording/recording_reader.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "core/content_hash.h"
#include "recording/recording_layout.h"
#include "wire/frame_stream.h"
#include "wire/varint.h"

namespace livegs {

using namespace recording_layout;

namespace {

bool is(uint8_t kind, ChunkKind wanted) { return kind == static_cast<uint8_t>(wanted); }

template <class Message>
bool parse(Message& message, std::span<const std::byte> bytes) {
  return message.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
}

}  // namespace

Error RecordingReader::bad(const std::string& what) const {
  return with_remedy(invalid_data(file_.path().string() + ": " + what), "copy the recording again");
}

Result<RecordingReader> RecordingReader::open(const std::filesystem::path& path) {
  auto file = RecordingFile::open(path);
  if (!file) return file.error();
  RecordingReader reader(std::move(*file));
  if (auto begun = reader.read_start(); !begun) return begun.error();
  if (reader.read_index()) {
    reader.ended_in_order_ = true;
  } else {
    if (auto looked = reader.look_through(); !looked) return looked.error();
  }
  reader.rewind();
  return reader;
}

Result<std::optional<RecordingReader::Chunk>> RecordingReader::read_chunk(uint64_t offset) const {
  if (offset > file_.size() || file_.size() - offset < kChunkHeadBytes) return std::optional<Chunk>();
  std::array<std::byte, kChunkHeadBytes> head_bytes;
  if (auto read = file_.read(offset, head_bytes); !read) return read.error();
  ByteReader head(head_bytes);
  const auto size = head.read<uint32_t>();
  Chunk chunk;
  chunk.kind = head.read<uint8_t>();
  chunk.offset = offset;
  const auto check = head.read<uint32_t>();
  if (size > kMaxPayloadBytes)
    return bad("contains a chunk of over 64 MiB at offset " + std::to_string(offset));
  if (file_.size() - offset - kChunkHeadBytes < size) return std::optional<Chunk>();
  chunk.payload.resize(size);
  if (auto read = file_.read(offset + kChunkHeadBytes, chunk.payload); !read) return read.error();
  uint32_t sum = static_cast<uint32_t>(crc32_z(0, &chunk.kind, 1));
  sum = static_cast<uint32_t>(crc32_z(sum, reinterpret_cast<const Bytef*>(chunk.payload.data()), size));
  if (sum != check) return bad("is damaged at offset " + std::to_string(offset) + ": wrong checksum");
  return std::optional<Chunk>(std::move(chunk));
}

Result<void> RecordingReader::read_start() {
  std::array<std::byte, kMagic.size()> magic;
  if (file_.size() < magic.size()) return bad("is not a recording: too short; give a *.lvgrec file");
  if (auto read = file_.read(0, magic); !read) return read;
  const auto differs =
      std::mismatch(magic.begin(), magic.end(), kMagic.begin(),
                    [](std::byte byte, uint8_t wanted) { return std::to_integer<uint8_t>(byte) == wanted; });
  if (differs.first == magic.begin() + 6) {
    return unsupported(file_.path().string() + ": has version " +
                       std::to_string(std::to_integer<int>(magic[6])) + ", expected " +
                       std::to_string(kMagic[6]) + "; use the version of LiveGS that recorded it");
  }
  if (differs.first != magic.end()) return bad("is not a recording; give a *.lvgrec file");
  auto chunk = read_chunk(magic.size());
  if (!chunk) return chunk.error();
  if (!*chunk || !is((*chunk)->kind, ChunkKind::Start) || !parse(start_, (*chunk)->payload))
    return bad("has no valid start chunk");
  first_ = magic.size() + kChunkHeadBytes + (*chunk)->payload.size();
  return {};
}

Result<void> RecordingReader::read_index() {
  std::array<std::byte, kTrailerBytes> trailer_bytes;
  if (file_.size() < first_ + kTrailerBytes) return bad("has no index");
  if (auto read = file_.read(file_.size() - kTrailerBytes, trailer_bytes); !read) return read;
  ByteReader trailer(trailer_bytes);
  const auto offset = trailer.read<uint64_t>();
  for (const uint8_t byte : kIndexMagic) {
    if (trailer.read<uint8_t>() != byte) return bad("has no index");
  }
  auto chunk = read_chunk(offset);
  if (!chunk) return chunk.error();
  if (!*chunk || !is((*chunk)->kind, ChunkKind::Index)) return bad("has no index");
  const std::span<const std::byte> payload((*chunk)->payload);
  ByteReader in(payload);
  const auto size = read_varint(in);
  if (!size || *size > in.remaining() || !parse(totals_, payload.subspan(in.offset(), *size)))
    return bad("has no index");
  in.skip(*size);
  const auto count = read_varint(in);
  if (!count || *count > in.remaining()) return bad("has no index");
  KeyTick key;
  for (uint64_t i = 0; i < *count; ++i) {
    const auto tick = read_varint(in), passed_ns = read_varint(in), bytes = read_varint(in);
    if (!tick || !passed_ns || !bytes) return bad("has no index");
    key.tick += *tick;
    key.simulated_ns = static_cast<int64_t>(static_cast<uint64_t>(key.simulated_ns) +
                                            static_cast<uint64_t>(unzigzag(*passed_ns)));
    key.offset += *bytes;
    keys_.push_back(key);
  }
  return {};
}

Result<void> RecordingReader::look_through() {
  keys_.clear();
  RecordingCount count;
  rewind();
  uint64_t objects_at = 0;  // 0: none since the last tick
  for (uint64_t at = first_;;) {
    auto read = read_chunk(at);
    if (!read || !*read) break;  // the readable part ends here
    const Chunk& chunk = **read;
    at += kChunkHeadBytes + chunk.payload.size();
    if (is(chunk.kind, ChunkKind::Objects)) objects_at = chunk.offset;
    if (is(chunk.kind, ChunkKind::Object)) {
      const auto event = read_event(chunk);
      if (!event) break;
      count.take(event->event);
    }
    if (!is(chunk.kind, ChunkKind::Tick)) continue;
    const auto record = decode_tick(chunk.payload, samples_);
    if (!record) break;
    int64_t simulated_ns = tick_time_ns(record->tick, start_.rate_hz());
    if (!record->frame.empty()) {
      const auto time_ns = stream_frame_time_ns(record->frame);
      if (!time_ns) break;
      simulated_ns = *time_ns;
    }
    count.take(*record, simulated_ns);
    if (record->key && objects_at > 0) keys_.push_back({record->tick, simulated_ns, objects_at});
    objects_at = 0;
  }
  totals_ = count.totals();
  return {};
}

void RecordingReader::rewind() {
  at_ = first_;
  samples_.clear();
}

Result<RecordedEvent> RecordingReader::read_event(const Chunk& chunk) const {
  ByteReader in(chunk.payload);
  const auto tick = read_varint(in);
  RecordedEvent event;
  if (!tick || !parse(event.event, std::span(chunk.payload).subspan(in.offset())))
    return bad("contains an invalid event at offset " + std::to_string(chunk.offset));
  event.tick = *tick;
  return event;
}

Result<std::optional<RecordedItem>> RecordingReader::next() {
  for (;;) {
    auto read = read_chunk(at_);
    if (!read) return read.error();
    if (!*read) return std::optional<RecordedItem>();
    const Chunk& chunk = **read;
    if (is(chunk.kind, ChunkKind::Index)) return std::optional<RecordedItem>();
    if (is(chunk.kind, ChunkKind::Object)) {
      auto event = read_event(chunk);
      if (!event) return event.error();
      at_ += kChunkHeadBytes + chunk.payload.size();
      return std::optional<RecordedItem>(std::move(*event));
    }
    if (is(chunk.kind, ChunkKind::Tick)) {
      auto record = decode_tick(chunk.payload, samples_);
      if (!record) return bad("at offset " + std::to_string(chunk.offset) + ": " + record.error().message);
      at_ += kChunkHeadBytes + chunk.payload.size();
      return std::optional<RecordedItem>(std::move(*record));
    }
    at_ += kChunkHeadBytes + chunk.payload.size();
  }
}

Result<std::vector<uint64_t>> RecordingReader::read_objects(const Chunk& chunk) const {
  ByteReader in(chunk.payload);
  const auto tick = read_varint(in), count = read_varint(in);
  if (!tick || !count || *count > in.remaining()) return bad("contains an invalid object list");
  std::vector<uint64_t> offsets;
  for (uint64_t i = 0; i < *count; ++i) {
    const auto step = read_varint(in);
    if (!step) return bad("contains an invalid object list");
    offsets.push_back(i == 0 ? *step : offsets.back() + static_cast<uint64_t>(unzigzag(*step)));
  }
  return offsets;
}

Result<std::vector<v1::ObjectDescription>> RecordingReader::seek(int64_t simulated_ns) {
  if (keys_.empty()) return not_found(file_.path().string() + ": has no key tick; copy the recording again");
  auto after =
      std::upper_bound(keys_.begin(), keys_.end(), simulated_ns,
                       [](int64_t moment_ns, const KeyTick& key) { return moment_ns < key.simulated_ns; });
  const KeyTick& key = after == keys_.begin() ? *after : *std::prev(after);
  auto listed = read_chunk(key.offset);
  if (!listed) return listed.error();
  if (!*listed || !is((*listed)->kind, ChunkKind::Objects)) return bad("has no object list at a key tick");
  auto offsets = read_objects(**listed);
  if (!offsets) return offsets.error();
  std::vector<v1::ObjectDescription> objects;
  for (const uint64_t offset : *offsets) {
    auto chunk = read_chunk(offset);
    if (!chunk) return chunk.error();
    if (!*chunk || !is((*chunk)->kind, ChunkKind::Object))
      return bad("has no object description at a key tick");
    auto event = read_event(**chunk);
    if (!event) return event.error();
    v1::SessionEvent& described = event->event;
    if (!described.has_object_added() && !described.has_object_changed())
      return bad("has no object description at a key tick");
    v1::ObjectDescription& object = described.has_object_added() ? *described.mutable_object_added()
                                                                 : *described.mutable_object_changed();
    if (!objects.empty() && object.object_id() <= objects.back().object_id())
      return bad("lists objects out of order");
    objects.push_back(std::move(object));
  }
  at_ = key.offset + kChunkHeadBytes + (*listed)->payload.size();
  samples_.clear();
  return objects;
}

Result<std::vector<std::byte>> RecordingReader::asset(const std::string& hash) {
  constexpr size_t kHead = 32 + 16;
  std::vector<std::byte> bytes;
  for (uint64_t at = first_;;) {
    // Reads only the heads, except for the requested asset.
    std::array<std::byte, kChunkHeadBytes + kHead> head_bytes;
    if (at > file_.size() || file_.size() - at < kChunkHeadBytes) break;
    const size_t shown = std::min<uint64_t>(head_bytes.size(), file_.size() - at);
    if (auto read = file_.read(at, std::span(head_bytes).first(shown)); !read) return read.error();
    ByteReader head(std::span<const std::byte>(head_bytes).first(shown));
    const auto size = head.read<uint32_t>();
    const auto kind = head.read<uint8_t>();
    const bool wanted = is(kind, ChunkKind::Asset) && shown == head_bytes.size() &&
                        hexadecimal(std::span(head_bytes).subspan(kChunkHeadBytes, 32)) == hash;
    if (wanted) {
      auto chunk = read_chunk(at);
      if (!chunk) return chunk.error();
      if (!*chunk || (*chunk)->payload.size() < kHead) break;
      ByteReader piece(std::span<const std::byte>((*chunk)->payload).subspan(32));
      const auto offset = piece.read<uint64_t>(), total = piece.read<uint64_t>();
      if (offset != bytes.size()) return bad("contains the pieces of an asset out of order");
      bytes.insert(bytes.end(), (*chunk)->payload.begin() + kHead, (*chunk)->payload.end());
      if (bytes.size() >= total) return bytes;
    }
    at += kChunkHeadBytes + size;
  }
  return not_found(file_.path().string() + ": does not contain the asset " + hash.substr(0, 12));
}

Result<void> RecordingReader::files(
    const std::function<Result<void>(const RecordedFilePiece& piece)>& take) const {
  std::string name;  // of the current file, at byte `next` of `total`
  uint64_t next = 0, total = 0;
  for (uint64_t at = first_;;) {
    std::array<std::byte, kChunkHeadBytes> head_bytes;
    if (at > file_.size() || file_.size() - at < kChunkHeadBytes) break;
    if (auto read = file_.read(at, head_bytes); !read) return read.error();
    ByteReader head(head_bytes);
    const auto size = head.read<uint32_t>();
    if (is(head.read<uint8_t>(), ChunkKind::File)) {
      const auto chunk = read_chunk(at);
      if (!chunk) return chunk.error();
      if (!*chunk) break;
      const std::span<const std::byte> payload((*chunk)->payload);
      ByteReader in(payload);
      const auto length = read_varint(in);
      if (!length || *length == 0 || *length > kMaxFileNameBytes || *length > in.remaining())
        return bad("contains a file without a name");
      RecordedFilePiece piece;
      piece.name.assign(reinterpret_cast<const char*>(payload.data()) + in.offset(), *length);
      in.skip(*length);
      piece.offset = in.read<uint64_t>();
      piece.total = in.read<uint64_t>();
      if (in.failed()) return bad("contains an invalid piece of a file");
      piece.bytes = payload.subspan(in.offset());
      const bool goes_on = next < total;
      if (piece.offset != next || (goes_on && (piece.name != name || piece.total != total)) ||
          piece.bytes.size() > piece.total - next || (piece.bytes.empty() && piece.total > 0)) {
        return bad("contains the pieces of a file out of order");
      }
      if (auto taken = take(piece); !taken) return taken;
      name = piece.name;
      total = piece.total;
      next += piece.bytes.size();
      if (next == total) next = total = 0;
    }
    at += kChunkHeadBytes + size;
  }
  return {};
}

}  // namespace livegs
