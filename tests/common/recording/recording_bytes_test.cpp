// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <zlib.h>

#include <fstream>

#include "common/recording/recorded_session.h"
#include "common/wire/mutations.h"
#include "core/file.h"
#include "recording/recording_layout.h"
#include "scratch_folder.h"
#include "wire/little_endian.h"

namespace livegs {
namespace {

using namespace livegs::testing;

void write_bytes(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<long>(bytes.size()));
}

// Calls every function of a reader.
void use(const std::filesystem::path& path) {
  auto reader = RecordingReader::open(path);
  if (!reader) {
    EXPECT_NE(reader.error().message.find("; "), std::string::npos) << reader.error().message;
    return;
  }
  for (const int64_t moment_ns : {int64_t{0}, int64_t{2'000'000'000}, INT64_MAX}) {
    StreamReader stream;
    if (auto objects = reader->seek(moment_ns); !objects) continue;
    for (;;) {
      auto item = reader->next();
      if (!item || !*item) break;
      if (const auto* record = std::get_if<TickRecord>(&**item)) (void)stream.read(record->frame);
    }
  }
  (void)reader->asset(std::string(64, 'a'));
  (void)reader->files([](const RecordedFilePiece&) -> Result<void> { return {}; });
}

std::vector<std::byte> session_bytes(const ScratchFolder& folder) {
  auto writer = write_session(folder / "good.lvgrec", 300);
  EXPECT_TRUE(writer);
  EXPECT_TRUE(writer->add_asset(std::string(64, 'a'), std::vector<std::byte>(100)));
  EXPECT_TRUE(writer->add_file("cup.ply", std::vector<std::byte>(100)));
  EXPECT_TRUE(writer->finish());
  auto bytes = read_file(folder / "good.lvgrec");
  EXPECT_TRUE(bytes);
  return *bytes;
}

TEST(RecordingBytes, AreReadOrRejected) {
  const ScratchFolder folder;
  const std::vector<std::byte> good = session_bytes(folder);
  for_each_mutation(good, 300, 11, [&](std::span<const std::byte> spoilt) {
    write_bytes(folder / "bad.lvgrec", spoilt);
    use(folder / "bad.lvgrec");
  });
}

// Checksums hide damaged payloads from the decoders; here they are corrected after each mutation.
TEST(RecordingBytes, WithValidChecksumsAreReadOrRejected) {
  const ScratchFolder folder;
  const std::vector<std::byte> good = session_bytes(folder);
  constexpr size_t kHead = recording_layout::kChunkHeadBytes;
  struct Chunk {
    uint8_t kind;
    std::vector<std::byte> payload;
  };
  std::vector<Chunk> chunks;
  for (size_t at = 8; at + kHead <= good.size() - recording_layout::kTrailerBytes;) {
    ByteReader head(std::span<const std::byte>(good).subspan(at, kHead));
    const auto size = head.read<uint32_t>();
    const auto kind = head.read<uint8_t>();
    chunks.push_back({kind,
                      {good.begin() + static_cast<long>(at + kHead),
                       good.begin() + static_cast<long>(at + kHead + size)}});
    at += kHead + size;
  }
  ASSERT_GT(chunks.size(), 300u);
  std::mt19937_64 random(12);
  for (int round = 0; round < 300; ++round) {
    // Chunks other than ticks are few, so they are chosen as often as ticks.
    size_t chosen = random() % chunks.size();
    if (round % 2 == 0) {
      while (chunks[chosen].kind == 4) chosen = random() % chunks.size();
    }
    for_each_mutation(chunks[chosen].payload, 1, random(), [&](std::span<const std::byte> spoilt) {
      std::vector<std::byte> bytes(good.begin(), good.begin() + 8);
      uint64_t index_at = 0;
      for (size_t i = 0; i < chunks.size(); ++i) {
        const std::span<const std::byte> payload =
            i == chosen ? spoilt : std::span<const std::byte>(chunks[i].payload);
        uint32_t sum = static_cast<uint32_t>(crc32_z(0, &chunks[i].kind, 1));
        sum = static_cast<uint32_t>(
            crc32_z(sum, reinterpret_cast<const Bytef*>(payload.data()), payload.size()));
        if (chunks[i].kind == 6) index_at = bytes.size();
        ByteWriter head;
        head.write(static_cast<uint32_t>(payload.size()));
        head.write(chunks[i].kind);
        head.write(sum);
        const auto front = std::move(head).take();
        bytes.insert(bytes.end(), front.begin(), front.end());
        bytes.insert(bytes.end(), payload.begin(), payload.end());
      }
      ByteWriter trailer;
      trailer.write(index_at);
      const auto end = std::move(trailer).take();
      bytes.insert(bytes.end(), end.begin(), end.end());
      bytes.insert(bytes.end(), good.end() - 8, good.end());
      write_bytes(folder / "bad.lvgrec", bytes);
      use(folder / "bad.lvgrec");
    });
  }
}

TEST(RecordingBytes, DetectAChangedByte) {
  const ScratchFolder folder;
  std::vector<std::byte> bytes = session_bytes(folder);
  bytes[bytes.size() / 2] ^= std::byte{1};
  write_bytes(folder / "bad.lvgrec", bytes);
  auto reader = RecordingReader::open(folder / "bad.lvgrec");  // the index is intact
  ASSERT_TRUE(reader);
  Result<std::optional<RecordedItem>> item = reader->next();
  while (item && *item) item = reader->next();
  ASSERT_FALSE(item);
  EXPECT_EQ(item.error().code, ErrorCode::InvalidData);
}

TEST(RecordingBytes, ReportAnotherVersion) {
  const ScratchFolder folder;
  std::vector<std::byte> bytes = session_bytes(folder);
  bytes[6] = std::byte{9};
  write_bytes(folder / "new.lvgrec", bytes);
  const auto reader = RecordingReader::open(folder / "new.lvgrec");
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().code, ErrorCode::Unsupported);
  EXPECT_NE(reader.error().message.find("has version 9, expected 1"), std::string::npos);
}

}  // namespace
}  // namespace livegs
