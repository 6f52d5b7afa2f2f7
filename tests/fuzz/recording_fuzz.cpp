// SPDX-License-Identifier: Apache-2.0
// Recordings (proto/recording_format.md).
// Even first byte: the rest is the file.
// Odd first byte: the rest is a list of chunks, each preceded by its kind. The target adds check sums and the
// trailer, which otherwise stop most damaged data before the decoders behind them.
#include <sys/mman.h>
#include <unistd.h>
#include <zlib.h>

#include "fuzz/moving_objects.h"
#include "recording/recording_layout.h"
#include "recording/recording_reader.h"
#include "recording/recording_writer.h"
#include "wire/rest_body_codec.h"

namespace livegs::fuzz::recording_fuzz {
namespace {

using namespace recording_layout;

// A file in memory that can be opened by path.
class MemoryFile {
 public:
  explicit MemoryFile(std::span<const std::byte> bytes = {})
      : descriptor_(::memfd_create("fuzz", MFD_CLOEXEC)) {
    check(descriptor_ >= 0 &&
              ::write(descriptor_, bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()),
          "a memory file can be created and written");
  }
  ~MemoryFile() { ::close(descriptor_); }
  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  const int descriptor_;
};

void append(Bytes& file, std::span<const std::byte> bytes) {
  file.insert(file.end(), bytes.begin(), bytes.end());
}

Bytes file_of_chunks(std::span<const std::byte> input) {
  Bytes file;
  for (const uint8_t byte : kMagic) file.push_back(static_cast<std::byte>(byte));
  uint64_t index_at = 0;
  for (const auto part : parts_of(input)) {
    if (part.empty()) continue;
    const auto kind = std::to_integer<uint8_t>(part[0]);
    const auto payload = part.subspan(1);
    auto sum = static_cast<uint32_t>(crc32_z(0, &kind, 1));
    sum = static_cast<uint32_t>(crc32_z(sum, reinterpret_cast<const Bytef*>(payload.data()), payload.size()));
    if (kind == static_cast<uint8_t>(ChunkKind::Index)) index_at = file.size();
    ByteWriter head;
    head.write(static_cast<uint32_t>(payload.size()));
    head.write(kind);
    head.write(sum);
    append(file, std::move(head).take());
    append(file, payload);
  }
  if (index_at > 0) {
    ByteWriter trailer;
    trailer.write(index_at);
    for (const uint8_t byte : kIndexMagic) trailer.write(byte);
    append(file, std::move(trailer).take());
  }
  return file;
}

Bytes chunks_of_file(const Bytes& file) {
  std::vector<Bytes> chunks;
  for (size_t at = kMagic.size(); at + kChunkHeadBytes + kTrailerBytes <= file.size();) {
    const std::span<const std::byte> bytes(file);
    ByteReader head(bytes.subspan(at, kChunkHeadBytes));
    const auto size = head.read<uint32_t>();
    Bytes chunk{static_cast<std::byte>(head.read<uint8_t>())};
    append(chunk, bytes.subspan(at + kChunkHeadBytes, size));
    chunks.push_back(std::move(chunk));
    at += kChunkHeadBytes + size;
  }
  return joined(chunks);
}

// Calls all functions of the reader on the first ticks. Decoding many frames is left to the frame target.
void use(RecordingReader& reader) {
  for (const int64_t moment_ns : {INT64_MIN, int64_t{100'000'000}, INT64_MAX}) {
    if (moment_ns == INT64_MIN)
      reader.rewind();
    else if (!reader.seek(moment_ns))
      continue;
    StreamReader stream;
    uint64_t ticks = 0;
    for (; ticks < 64; ++ticks) {
      const auto item = reader.next();
      if (!item || !*item) break;
      const auto* tick = std::get_if<TickRecord>(&**item);
      if (!tick) continue;
      if (const auto frame = stream.read(tick->frame)) check_finite(*frame);
      for (const SessionSamples& session : tick->actions.samples) {
        for (const InputSample& sample : session.samples) {
          for (const HandSample& hand : sample.hands)
            check(hand.aim.position_m.allFinite(), "samples are finite");
        }
      }
    }
  }
  (void)reader.asset(std::string(64, 'a'));
  (void)reader.files([](const RecordedFilePiece& piece) -> Result<void> {
    check(!piece.name.empty() && piece.offset + piece.bytes.size() <= piece.total,
          "a piece is inside its file");
    return {};
  });
}

}  // namespace

void look_at(std::span<const std::byte> input) {
  if (input.empty()) return;
  const bool chunks = (std::to_integer<uint8_t>(input[0]) & 1) != 0;
  const MemoryFile file(chunks ? file_of_chunks(input.subspan(1)) : Bytes(input.begin() + 1, input.end()));
  if (auto reader = RecordingReader::open(file.path())) use(*reader);
}

std::vector<Bytes> seeds() {
  const std::string path = "/tmp/livegs_fuzz_" + std::to_string(::getpid()) + ".lvgrec";
  std::vector<Bytes> seeds;
  for (const bool inputs_only : {false, true}) {
    ::unlink(path.c_str());
    v1::RecordingStart start;
    start.set_rate_hz(90);
    start.mutable_scene()->set_name("synthetic");
    start.set_inputs_only(inputs_only);
    auto writer = RecordingWriter::create(path, start);
    check(writer.has_value(), "a recording can be created in /tmp");
    v1::SessionEvent event;
    v1::ObjectDescription& object = *event.mutable_object_added();
    object.set_object_id(3);
    object.set_asset_hash(std::string(64, 'a'));
    const Bytes rest = encode_rest_body(rest_bodies()[2]);
    object.set_rest_body(rest.data(), rest.size());
    check(writer->add_event(1, event).has_value(), "an event is written");
    for (uint64_t number = 1; number <= 12; ++number) {
      const DriverFrame frame = frame_at(number);
      RecordingWriter::Tick tick;
      tick.tick = number;
      tick.drivers = &frame;
      InputSample sample;
      sample.sequence = number;
      sample.hands[number % 2].active = true;
      sample.hands[number % 2].aim.position_m =
          Eigen::Vector3f(0.1f * static_cast<float>(number), 1, 0).cast<double>();
      tick.actions.samples.push_back({7, {sample}});
      if (number == 5) tick.actions.cuts = {9, 12};
      if (number == 6) tick.actions.changes.emplace_back().mutable_force()->set_object("thing");
      if (number == 8) tick.actions.released = {7};
      if (number == 9) tick.actions.over = {7};
      check(writer->add_tick(std::move(tick)).has_value(), "a tick is written");
    }
    check(writer->add_asset(std::string(64, 'a'), Bytes(100)).has_value(), "an asset is written");
    check(writer->add_file("../cup.ply", Bytes(50)).has_value(), "a file is written");
    check(writer->finish().has_value(), "the recording is finished");
    Bytes file(writer->bytes());
    std::FILE* const in = std::fopen(path.c_str(), "rb");
    check(in && std::fread(file.data(), 1, file.size(), in) == file.size(), "the recording can be read");
    std::fclose(in);
    ::unlink(path.c_str());
    Bytes raw{std::byte{0}}, chunks{std::byte{1}};
    append(raw, file);
    append(chunks, chunks_of_file(file));
    seeds.push_back(raw);
    seeds.push_back(chunks);
  }
  return seeds;
}

[[maybe_unused]] const bool kAdded = add_target({"recording", look_at, seeds});

}  // namespace livegs::fuzz::recording_fuzz
