// SPDX-License-Identifier: Apache-2.0
// The layout is proto/recording_format.md, "Tick".
#include "recording/tick_record.h"

#include <utility>

#include "wire/varint.h"

namespace livegs {
namespace {

constexpr uint8_t kStepped = 1, kFrame = 2, kKey = 4, kActions = 8, kScene = 16, kReservedTickFlags = 0xE0;

Error bad(const std::string& what) { return invalid_data("recorded tick: " + what); }

void write_message(ByteWriter& out, const google::protobuf::MessageLite& message) {
  const std::string bytes = message.SerializeAsString();
  write_varint(out, bytes.size());
  for (const char byte : bytes) out.write(static_cast<uint8_t>(byte));
}

template <class Ids>
void write_ids(ByteWriter& out, const Ids& ids) {
  write_varint(out, ids.size());
  for (const uint64_t id : ids) write_varint(out, id);
}

void write_actions(ByteWriter& out, const TickActions& actions, uint64_t tick, SamplesBefore& before) {
  write_varint(out, actions.changes.size());
  for (const v1::SceneChange& change : actions.changes) write_message(out, change);
  write_ids(out, actions.over);
  write_varint(out, actions.samples.size());
  for (const SessionSamples& one : actions.samples) {
    write_varint(out, one.session);
    write_varint(out, one.samples.size());
    for (const InputSample& sample : one.samples) write_sample(out, sample, tick, before[one.session]);
  }
  write_ids(out, actions.released);
  write_ids(out, actions.cuts);
}

// Reads a count of entries that take at least one byte each.
std::optional<size_t> read_count(ByteReader& in) {
  const auto count = read_varint(in);
  if (!count || *count > in.remaining()) return std::nullopt;
  return static_cast<size_t>(*count);
}

template <class Message>
bool read_message(ByteReader& in, std::span<const std::byte> bytes, Message& message) {
  const auto size = read_count(in);
  if (!size) return false;
  const std::span<const std::byte> own = bytes.subspan(in.offset(), *size);
  in.skip(*size);
  return message.ParseFromArray(own.data(), static_cast<int>(own.size()));
}

template <class Id>
bool read_ids(ByteReader& in, std::vector<Id>& ids) {
  const auto count = read_count(in);
  for (size_t i = 0; count && i < *count; ++i) {
    const auto id = read_varint(in);
    if (!id || !std::in_range<Id>(*id)) return false;
    ids.push_back(static_cast<Id>(*id));
  }
  return count.has_value();
}

bool read_samples(ByteReader& in, TickActions& actions, uint64_t tick, SamplesBefore& before) {
  const auto sessions = read_count(in);
  for (size_t i = 0; sessions && i < *sessions; ++i) {
    SessionSamples one;
    const auto session = read_varint(in);
    const auto count = session ? read_count(in) : std::nullopt;
    if (!count || (!actions.samples.empty() && *session <= actions.samples.back().session)) return false;
    one.session = *session;
    for (size_t k = 0; k < *count; ++k) {
      auto sample = read_sample(in, tick, before[one.session]);
      if (!sample) return false;
      one.samples.push_back(*sample);
    }
    actions.samples.push_back(std::move(one));
  }
  return sessions.has_value();
}

bool read_actions(ByteReader& in, std::span<const std::byte> bytes, TickRecord& record,
                  SamplesBefore& before) {
  TickActions& actions = record.actions;
  const auto changes = read_count(in);
  for (size_t i = 0; changes && i < *changes; ++i) {
    if (!read_message(in, bytes, actions.changes.emplace_back())) return false;
  }
  return changes && read_ids(in, actions.over) && read_samples(in, actions, record.tick, before) &&
         read_ids(in, actions.released) && read_ids(in, actions.cuts);
}

}  // namespace

std::vector<std::byte> encode_tick(const TickRecord& record, SamplesBefore& before) {
  if (record.key) before.clear();
  const TickActions& actions = record.actions;
  ByteWriter out;
  out.reserve(record.frame.size() + 64);
  write_varint(out, record.tick);
  out.write(static_cast<uint8_t>((actions.stepped ? kStepped : 0) | (record.frame.empty() ? 0 : kFrame) |
                                 (record.key ? kKey : 0) | (actions.empty() ? 0 : kActions) |
                                 (record.scene ? kScene : 0)));
  if (record.scene) write_message(out, *record.scene);
  if (!actions.empty()) write_actions(out, actions, record.tick, before);
  write_varint(out, record.hashes.size());
  uint32_t last_id = 0;
  for (const ObjectHash& one : record.hashes) {
    write_varint(out, one.object_id - std::exchange(last_id, one.object_id));
    out.write(one.hash);
  }
  std::vector<std::byte> bytes = std::move(out).take();
  bytes.insert(bytes.end(), record.frame.begin(), record.frame.end());
  return bytes;
}

Result<TickRecord> decode_tick(std::span<const std::byte> bytes, SamplesBefore& before) {
  ByteReader in(bytes);
  TickRecord record;
  const auto tick = read_varint(in);
  const auto flags = in.read<uint8_t>();
  if (!tick || in.failed()) return bad("is truncated");
  if ((flags & kReservedTickFlags) != 0) return bad("sets a reserved bit");
  record.tick = *tick;
  record.key = (flags & kKey) != 0;
  if (record.key) before.clear();
  record.actions.stepped = (flags & kStepped) != 0;
  if ((flags & kScene) != 0 && !read_message(in, bytes, record.scene.emplace()))
    return bad("contains an invalid scene");
  if ((flags & kActions) != 0 && !read_actions(in, bytes, record, before))
    return bad("contains invalid actions");
  const auto hashes = read_count(in);
  if (!hashes) return bad("is truncated");
  uint64_t id = 0;
  for (size_t i = 0; i < *hashes; ++i) {
    const auto step = read_varint(in);
    if (!step || (i > 0 && *step == 0) || *step > UINT32_MAX || (id += *step) > UINT32_MAX)
      return bad("lists ids out of order");
    record.hashes.push_back({static_cast<uint32_t>(id), in.read<uint32_t>()});
  }
  if (in.failed()) return bad("is truncated");
  if ((flags & kFrame) == 0 && in.remaining() > 0) return bad("has trailing bytes");
  const std::span<const std::byte> frame = bytes.subspan(in.offset());
  if ((flags & kFrame) != 0 && frame.empty()) return bad("has no frame");
  record.frame.assign(frame.begin(), frame.end());
  return record;
}

}  // namespace livegs
