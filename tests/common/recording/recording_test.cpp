// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <map>

#include "common/recording/recorded_session.h"
#include "core/file.h"
#include "recording/recording_layout.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

using namespace livegs::testing;

struct Seen {
  std::vector<uint64_t> ticks;
  std::vector<DriverFrame> frames;
  std::vector<std::pair<uint64_t, v1::SessionEvent>> events;
  std::vector<InputSample> samples;
};

Seen read_all(RecordingReader& reader) {
  Seen seen;
  StreamReader stream;
  for (;;) {
    auto item = reader.next();
    EXPECT_TRUE(item) << item.error().message;
    if (!item || !*item) return seen;
    if (const auto* event = std::get_if<RecordedEvent>(&**item)) {
      seen.events.emplace_back(event->tick, event->event);
      continue;
    }
    const auto& record = std::get<TickRecord>(**item);
    seen.ticks.push_back(record.tick);
    for (const SessionSamples& one : record.actions.samples)
      seen.samples.insert(seen.samples.end(), one.samples.begin(), one.samples.end());
    if (record.frame.empty()) continue;
    auto frame = stream.read(record.frame);
    EXPECT_TRUE(frame) << frame.error().message;
    if (frame) seen.frames.push_back(std::move(*frame));
  }
}

// Stream quantisation error: half a step of 2^-18 m, and 18 bits per quaternion component.
void expect_near(const DriverFrame& seen, const DriverFrame& was) {
  ASSERT_EQ(seen.tick, was.tick);
  ASSERT_EQ(seen.simulated_ns, was.simulated_ns);
  ASSERT_EQ(seen.objects.size(), was.objects.size());
  for (size_t i = 0; i < was.objects.size(); ++i) {
    const Pose &a = seen.objects[i].poses[0], &b = was.objects[i].poses[0];
    EXPECT_LT((a.position_m - b.position_m).cwiseAbs().maxCoeff(), 0.5001 * std::ldexp(1.0, -18));
    EXPECT_LT(a.orientation.angularDistance(b.orientation), 0.0012 * M_PI / 180);
  }
}

void expect_same(const InputSample& a, const InputSample& b) {
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.sampled_ns, b.sampled_ns);
  EXPECT_EQ(a.for_tick, b.for_tick);
  EXPECT_EQ(a.hands[1].aim.position_m, b.hands[1].aim.position_m);
  EXPECT_EQ(a.hands[1].trigger, b.hands[1].trigger);
  EXPECT_EQ(a.hands[0].active, b.hands[0].active);
}

TEST(Recording, ContainsEveryTickEventAndInput) {
  const ScratchFolder folder;
  auto writer = write_session(folder / "a.lvgrec", 700);
  ASSERT_TRUE(writer) << writer.error().message;
  ASSERT_TRUE(writer->finish());
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_TRUE(reader->ended_in_order());
  EXPECT_EQ(reader->totals().ticks(), 700u);
  EXPECT_EQ(reader->totals().inputs(), 700u);
  EXPECT_EQ(reader->totals().objects_added(), 2u);
  EXPECT_EQ(reader->totals().objects_removed(), 1u);
  EXPECT_EQ(reader->keys().size(), 6u);
  const Seen seen = read_all(*reader);
  ASSERT_EQ(seen.frames.size(), 700u);
  ASSERT_EQ(seen.samples.size(), 700u);
  for (uint64_t tick = 1; tick <= 700; ++tick) {
    expect_near(seen.frames[tick - 1], frame_at(tick));
    expect_same(seen.samples[tick - 1], sample_at(tick));
  }
  ASSERT_EQ(seen.events.size(), 3u);
  EXPECT_EQ(seen.events[1].first, 400u);
  EXPECT_EQ(seen.events[2].second.object_removed().object_id(), 2u);
}

TEST(Recording, TruncatedIsReadToTheLastWholeChunk) {
  const ScratchFolder folder;
  auto writer = write_session(folder / "whole.lvgrec", 700);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->finish());
  const auto bytes = read_file(folder / "whole.lvgrec");
  ASSERT_TRUE(bytes);
  auto whole = RecordingReader::open(folder / "whole.lvgrec");
  ASSERT_TRUE(whole);
  uint64_t before = 0;
  for (size_t share = 1; share <= 10; ++share) {
    const size_t size = (bytes->size() - 40) * share / 10;
    std::ofstream(folder / "cut.lvgrec", std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes->data()), size);
    auto cut = RecordingReader::open(folder / "cut.lvgrec");
    ASSERT_TRUE(cut) << cut.error().message;
    EXPECT_FALSE(cut->ended_in_order());
    const Seen seen = read_all(*cut);
    EXPECT_EQ(seen.frames.size(), cut->totals().ticks());
    EXPECT_EQ(cut->totals().last_tick(), seen.ticks.back());
    EXPECT_GT(seen.ticks.back(), before);
    // The key ticks are those in the index of the whole recording.
    for (size_t i = 0; i < cut->keys().size(); ++i) {
      EXPECT_EQ(cut->keys()[i].tick, whole->keys()[i].tick);
      EXPECT_EQ(cut->keys()[i].simulated_ns, whole->keys()[i].simulated_ns);
      EXPECT_EQ(cut->keys()[i].offset, whole->keys()[i].offset);
    }
    before = seen.ticks.back();
  }
  EXPECT_EQ(before, 700u);
}

TEST(Recording, SeeksByDecodingFewFrames) {
  const ScratchFolder folder;
  auto writer = write_session(folder / "a.lvgrec", 2000);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->finish());
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader);
  for (const uint64_t wanted : {1999u, 1u, 256u, 257u, 258u, 450u, 700u, 1300u}) {
    const DriverFrame was = frame_at(wanted);
    auto objects = reader->seek(was.simulated_ns);
    ASSERT_TRUE(objects) << objects.error().message;
    StreamReader stream;
    std::optional<DriverFrame> frame;
    size_t decoded = 0, there = objects->size();
    while (!frame || frame->simulated_ns < was.simulated_ns) {
      auto item = reader->next();
      ASSERT_TRUE(item && *item);
      if (const auto* event = std::get_if<RecordedEvent>(&**item)) {
        there = event->event.has_object_removed() ? there - 1 : there + 1;
        continue;
      }
      auto read = stream.read(std::get<TickRecord>(**item).frame);
      ASSERT_TRUE(read) << read.error().message;
      frame = std::move(*read);
      ++decoded;
    }
    expect_near(*frame, was);
    EXPECT_LE(decoded, recording_layout::kKeyInterval);
    EXPECT_EQ(there, second_is_there(wanted) ? 2u : 1u) << wanted;
  }
}

TEST(Recording, InputsOnlyHasEverythingButFrames) {
  const ScratchFolder folder;
  auto writer = write_session(folder / "a.lvgrec", 700, true);
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->finish());
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->start().inputs_only());
  EXPECT_EQ(reader->totals().frames(), 0u);
  EXPECT_EQ(reader->totals().ticks(), 700u);
  const Seen seen = read_all(*reader);
  EXPECT_EQ(seen.ticks.size(), 700u);
  EXPECT_EQ(seen.samples.size(), 700u);
}

TEST(Recording, ContainsAssetsOnRequest) {
  const ScratchFolder folder;
  std::vector<std::byte> asset((5u << 20) / 2);
  for (size_t i = 0; i < asset.size(); ++i) asset[i] = static_cast<std::byte>(i * 7 >> 3);
  const std::string hash(64, 'a'), empty_hash(64, 'b');
  auto writer = RecordingWriter::create(folder / "a.lvgrec", start_of_recording());
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->add_asset(empty_hash, {}));
  ASSERT_TRUE(writer->add_asset(hash, asset));
  ASSERT_TRUE(writer->add_file("empty", {}));
  ASSERT_TRUE(writer->add_file("../a thing.ply", asset));
  ASSERT_TRUE(writer->finish());
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader);
  auto read = reader->asset(hash);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, asset);
  EXPECT_TRUE(reader->asset(empty_hash));
  EXPECT_EQ(reader->asset(std::string(64, 'c')).error().code, ErrorCode::NotFound);
  std::map<std::string, std::vector<std::byte>> files;
  ASSERT_TRUE(reader->files([&](const RecordedFilePiece& piece) -> Result<void> {
    EXPECT_EQ(piece.offset, files[piece.name].size());
    files[piece.name].insert(files[piece.name].end(), piece.bytes.begin(), piece.bytes.end());
    return {};
  }));
  EXPECT_EQ(files, (std::map<std::string, std::vector<std::byte>>{{"../a thing.ply", asset}, {"empty", {}}}));
}

TEST(Recording, NeverOverwritesAFile) {
  const ScratchFolder folder;
  folder.write("a.lvgrec", "kept");
  auto writer = RecordingWriter::create(folder / "a.lvgrec", start_of_recording());
  ASSERT_FALSE(writer);
  EXPECT_NE(writer.error().message.find("already exists"), std::string::npos);
  EXPECT_EQ(*read_text_file(folder / "a.lvgrec"), "kept");
}

// A disk with 20 kB left: the error contains the file name, and the file is valid up to the failure.
TEST(Recording, EndsWithAWholeChunkOnAFullDisk) {
  const ScratchFolder folder;
  struct rlimit kept;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &kept), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit small = kept;
  small.rlim_cur = 20000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  auto writer = write_session(folder / "a.lvgrec", 2000);
  setrlimit(RLIMIT_FSIZE, &kept);
  std::signal(SIGXFSZ, handler);
  ASSERT_FALSE(writer);
  EXPECT_NE(writer.error().message.find("a.lvgrec: cannot be written: File too large"), std::string::npos)
      << writer.error().message;
  auto reader = RecordingReader::open(folder / "a.lvgrec");
  ASSERT_TRUE(reader) << reader.error().message;
  EXPECT_LE(reader->bytes(), 20000u);
  EXPECT_GT(reader->bytes(), 19000u);
  const Seen seen = read_all(*reader);
  EXPECT_EQ(seen.frames.size(), reader->totals().ticks());
  EXPECT_GT(seen.frames.size(), 100u);
}

}  // namespace
}  // namespace livegs
