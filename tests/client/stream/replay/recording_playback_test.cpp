// SPDX-License-Identifier: Apache-2.0
#include "stream/replay/recording_playback.h"

#include <gtest/gtest.h>

#include <set>

#include "common/recording/recorded_session.h"
#include "recording/recording_layout.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

using namespace livegs::testing;

constexpr double kPeriod_s = 0.011'111'111;

class RecordingPlaybackTest : public ::testing::Test {
 protected:
  std::filesystem::path write(uint64_t ticks, bool inputs_only = false) {
    auto writer = write_session(folder_ / "a.lvgrec", ticks, inputs_only);
    EXPECT_TRUE(writer);
    EXPECT_TRUE(writer->finish());
    return folder_ / "a.lvgrec";
  }
  // Takes items up to the next frame.
  std::optional<ReceivedFrame> next_frame(RecordingPlayback& playback) {
    while (auto item = playback.take()) {
      if (auto* frame = std::get_if<ReceivedFrame>(&*item)) {
        for (const ObjectDrivers& object : frame->drivers->objects)
          EXPECT_TRUE(there_.contains(object.object_id));
        EXPECT_EQ(there_.size(), frame->drivers->objects.size());
        return *frame;
      }
      if (const auto* added = std::get_if<ObjectAdded>(&*item)) {
        EXPECT_TRUE(there_.insert(added->object.id).second);
      }
      if (const auto* removed = std::get_if<ObjectRemoved>(&*item)) {
        EXPECT_EQ(there_.erase(removed->object_id), 1u);
      }
    }
    return std::nullopt;
  }
  ScratchFolder folder_;
  std::set<uint32_t> there_;
};

TEST_F(RecordingPlaybackTest, PlaysFromTheBeginningToTheEnd) {
  auto playback = RecordingPlayback::open(write(700));
  ASSERT_TRUE(playback) << playback.error().message;
  EXPECT_NEAR(playback->length_s(), 699 * kPeriod_s, 1e-9);
  for (uint64_t tick = 1; tick <= 700; ++tick) {
    const auto frame = next_frame(*playback);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->tick, tick);
  }
  EXPECT_FALSE(next_frame(*playback));
  EXPECT_FALSE(playback->error());
}

// Seeks forwards and backwards across additions and removals give the right frame and objects, and playback
// continues from there.
TEST_F(RecordingPlaybackTest, SeeksAnywhereAndContinues) {
  auto playback = RecordingPlayback::open(write(2000));
  ASSERT_TRUE(playback);
  (void)next_frame(*playback);
  for (const uint64_t tick : {500u, 450u, 700u, 399u, 400u, 1u, 600u, 599u, 2000u, 1500u, 2u, 513u}) {
    ASSERT_TRUE(playback->seek((static_cast<double>(tick - 1) + 0.001) * kPeriod_s));
    EXPECT_LE(playback->decoded(), recording_layout::kKeyInterval);
    for (uint64_t more = 0; more < 3 && tick + more <= 2000; ++more) {
      const auto frame = next_frame(*playback);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->tick, tick + more);
    }
  }
  ASSERT_TRUE(playback->seek(1e9));  // beyond the end: the last frame
  EXPECT_EQ(next_frame(*playback)->tick, 2000u);
  ASSERT_TRUE(playback->seek(-5));
  EXPECT_EQ(next_frame(*playback)->tick, 1u);
}

// Seeks directly after opening, and repeated seeks without a take in between, lose no additions or removals.
TEST_F(RecordingPlaybackTest, SeeksBeforeFirstTake) {
  const std::filesystem::path file = write(2000);
  for (const uint64_t tick : {1u, 500u, 1500u}) {
    there_.clear();
    auto playback = RecordingPlayback::open(file);
    ASSERT_TRUE(playback);
    for (const uint64_t at : {tick, uint64_t{700}, tick})
      ASSERT_TRUE(playback->seek((static_cast<double>(at - 1) + 0.001) * kPeriod_s));
    for (uint64_t more = 0; more < 3; ++more) {
      const auto frame = next_frame(*playback);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->tick, tick + more);
      EXPECT_FALSE(there_.empty());
    }
  }
}

TEST_F(RecordingPlaybackTest, RefusesRecordingWithoutFrames) {
  const auto playback = RecordingPlayback::open(write(20, true));
  ASSERT_FALSE(playback);
  EXPECT_NE(playback.error().message.find("no frames"), std::string::npos);
}

TEST_F(RecordingPlaybackTest, ReportsCorruptedByte) {
  const auto path = write(700);
  {
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(std::filesystem::file_size(path) / 2));
    file.put('\x5A');
  }
  auto playback = RecordingPlayback::open(path);
  ASSERT_TRUE(playback);
  uint64_t last = 0;
  while (const auto frame = next_frame(*playback)) last = frame->tick;
  EXPECT_GT(last, 100u);
  EXPECT_LT(last, 700u);
  ASSERT_TRUE(playback->error());
  EXPECT_NE(playback->error()->message.find("is damaged"), std::string::npos);
  ASSERT_TRUE(playback->seek(690 * kPeriod_s));  // behind it
  EXPECT_EQ(next_frame(*playback)->tick, 691u);
}

}  // namespace
}  // namespace livegs
