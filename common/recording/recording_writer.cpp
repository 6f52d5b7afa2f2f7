// SPDX-License-Identifier: Apache-2.0
// The layout is proto/recording_format.md.
#include "recording/recording_writer.h"

#include <zlib.h>

#include <algorithm>
#include <utility>

#include "core/assert.h"
#include "recording/recording_layout.h"
#include "wire/varint.h"

namespace livegs {

using namespace recording_layout;

namespace {

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

std::vector<std::byte> joined(ByteWriter front, std::span<const std::byte> rest) {
  std::vector<std::byte> all = std::move(front).take();
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

uint8_t hexadecimal(char digit) {
  return static_cast<uint8_t>(digit <= '9' ? digit - '0' : digit - 'a' + 10);
}

}  // namespace

RecordingWriter::RecordingWriter(RecordingFile file, const v1::RecordingStart& start)
    : file_(std::move(file)), inputs_only_(start.inputs_only()), rate_hz_(start.rate_hz()) {}

Result<RecordingWriter> RecordingWriter::create(const std::filesystem::path& path,
                                                const v1::RecordingStart& start) {
  auto file = RecordingFile::create(path);
  if (!file) return file.error();
  if (auto begun = file->append(std::as_bytes(std::span(kMagic))); !begun) return begun.error();
  RecordingWriter writer(std::move(*file), start);
  if (auto added = writer.append(static_cast<uint8_t>(ChunkKind::Start), bytes_of(start.SerializeAsString()));
      !added)
    return added.error();
  return writer;
}

Result<void> RecordingWriter::append(uint8_t kind, std::span<const std::byte> payload) {
  if (failed_) return *failed_;
  if (payload.size() > kMaxPayloadBytes) {
    failed_ = Error{ErrorCode::TooLarge, file_.path().string() + ": a chunk of the session is over 64 MiB"};
    return *failed_;
  }
  uint32_t check = static_cast<uint32_t>(crc32_z(0, &kind, 1));
  check =
      static_cast<uint32_t>(crc32_z(check, reinterpret_cast<const Bytef*>(payload.data()), payload.size()));
  ByteWriter head;
  head.reserve(kChunkHeadBytes + payload.size());
  head.write(static_cast<uint32_t>(payload.size()));
  head.write(kind);
  head.write(check);
  auto written = file_.append(joined(std::move(head), payload));
  if (!written) failed_ = written.error();
  return written;
}

Result<void> RecordingWriter::add_event(uint64_t tick, const v1::SessionEvent& event) {
  const uint64_t offset = file_.size();
  ByteWriter head;
  write_varint(head, tick);
  auto added = append(static_cast<uint8_t>(ChunkKind::Object),
                      joined(std::move(head), bytes_of(event.SerializeAsString())));
  if (!added) return added;
  count_.take(event);
  if (event.has_object_removed())
    described_at_.erase(event.object_removed().object_id());
  else
    described_at_[event.has_object_added() ? event.object_added().object_id()
                                           : event.object_changed().object_id()] = offset;
  return {};
}

Result<void> RecordingWriter::add_asset(const std::string& hash, std::span<const std::byte> bytes) {
  LIVEGS_ASSERT(hash.size() == 64);
  uint64_t offset = 0;
  do {
    const auto piece = bytes.subspan(offset, std::min<uint64_t>(kAssetPieceBytes, bytes.size() - offset));
    ByteWriter head;
    for (size_t i = 0; i < hash.size(); i += 2)
      head.write(static_cast<uint8_t>(hexadecimal(hash[i]) << 4 | hexadecimal(hash[i + 1])));
    head.write(offset);
    head.write(static_cast<uint64_t>(bytes.size()));
    if (auto added = append(static_cast<uint8_t>(ChunkKind::Asset), joined(std::move(head), piece)); !added)
      return added;
    offset += piece.size();
  } while (offset < bytes.size());
  return {};
}

Result<void> RecordingWriter::add_file(const std::string& name, std::span<const std::byte> bytes) {
  LIVEGS_ASSERT(!name.empty() && name.size() <= kMaxFileNameBytes);
  uint64_t offset = 0;
  do {
    const auto piece = bytes.subspan(offset, std::min<uint64_t>(kAssetPieceBytes, bytes.size() - offset));
    ByteWriter head;
    write_varint(head, name.size());
    for (const char letter : name) head.write(static_cast<uint8_t>(letter));
    head.write(offset);
    head.write(static_cast<uint64_t>(bytes.size()));
    if (auto added = append(static_cast<uint8_t>(ChunkKind::File), joined(std::move(head), piece)); !added)
      return added;
    offset += piece.size();
  } while (offset < bytes.size());
  return {};
}

Result<void> RecordingWriter::add_objects(uint64_t tick) {
  ByteWriter out;
  write_varint(out, tick);
  write_varint(out, described_at_.size());
  uint64_t before = 0;
  bool first = true;
  for (const auto& [id, offset] : described_at_) {
    write_varint(out, first ? offset : zigzag(static_cast<int64_t>(offset - before)));
    before = offset;
    first = false;
  }
  return append(static_cast<uint8_t>(ChunkKind::Objects), std::move(out).take());
}

Result<void> RecordingWriter::add_past(std::span<const std::byte> encoded) {
  LIVEGS_ASSERT(keys_.empty());
  const auto record = decode_tick(encoded, samples_);
  LIVEGS_ASSERT(record && !record->key);
  if (auto added = append(static_cast<uint8_t>(ChunkKind::Tick), encoded); !added) return added;
  count_.take(*record, 0);
  return {};
}

Result<void> RecordingWriter::add_tick(Tick tick) {
  LIVEGS_ASSERT(tick.drivers && tick.drivers->tick == tick.tick);
  TickRecord record;
  record.tick = tick.tick;
  record.actions = std::move(tick.actions);
  record.scene = std::move(tick.scene);
  int64_t simulated_ns = tick_time_ns(tick.tick, rate_hz_);
  record.key = keys_.empty() || tick.tick >= keys_.back().tick + kKeyInterval;
  record.hashes = hashes_.take(*tick.drivers);
  if (!inputs_only_) {
    simulated_ns = tick.drivers->simulated_ns;
    EncodedStreamFrame encoded = encode_stream_frame(*tick.drivers, record.key ? nullptr : written_);
    record.frame = std::move(encoded.bytes);
    written_ = std::move(encoded.next);
  }
  if (record.key) {
    const KeyTick key{tick.tick, simulated_ns, file_.size()};
    if (auto listed = add_objects(tick.tick); !listed) return listed;
    keys_.push_back(key);
  }
  const std::vector<std::byte> payload = encode_tick(record, samples_);
  if (auto added = append(static_cast<uint8_t>(ChunkKind::Tick), payload); !added) return added;
  count_.take(record, simulated_ns);
  return {};
}

Result<void> RecordingWriter::finish() {
  const uint64_t offset = file_.size();
  ByteWriter out;
  const std::string totals = count_.totals().SerializeAsString();
  write_varint(out, totals.size());
  std::vector<std::byte> payload = joined(std::move(out), bytes_of(totals));
  ByteWriter keys;
  write_varint(keys, keys_.size());
  KeyTick before;
  for (const KeyTick& key : keys_) {
    write_varint(keys, key.tick - before.tick);
    write_varint(keys, zigzag(key.simulated_ns - before.simulated_ns));
    write_varint(keys, key.offset - before.offset);
    before = key;
  }
  const std::vector<std::byte> listed = std::move(keys).take();
  payload.insert(payload.end(), listed.begin(), listed.end());
  if (auto added = append(static_cast<uint8_t>(ChunkKind::Index), payload); !added) return added;
  ByteWriter trailer;
  trailer.write(offset);
  for (const uint8_t byte : kIndexMagic) trailer.write(byte);
  auto ended = file_.append(std::move(trailer).take());
  failed_ = ended ? Error{ErrorCode::Internal, file_.path().string() + ": already finished"} : ended.error();
  return ended;
}

}  // namespace livegs
