// SPDX-License-Identifier: Apache-2.0
// Files of tracks, and points that are followed through pictures.
#include <gtest/gtest.h>

#include <cmath>
#include <span>

#include "fit/point_tracks.h"
#include "fit/simulation_journal.h"
#include "fit/tracks/point_tracker.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

TEST(TracksFile, ReadsWhatItWroteAndKeepsGaps) {
  const ScratchFolder scratch;
  PointTracks tracks;
  tracks.times_s = {0.5, 0.6, 0.75};
  for (int k = 0; k < 6; ++k) tracks.positions_px.emplace_back(10.25 * k, 3.5 - k);
  tracks.positions_px[4].setConstant(NAN);
  ASSERT_TRUE(write_tracks_file(scratch / "t.csv", tracks));
  const auto read = read_tracks_file(scratch / "t.csv");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->times_s, tracks.times_s);
  ASSERT_EQ(read->positions_px.size(), 6u);
  for (size_t k = 0; k < 6; ++k) {
    if (k == 4)
      EXPECT_TRUE(read->positions_px[k].hasNaN());
    else
      EXPECT_EQ(read->positions_px[k], tracks.positions_px[k]) << k;
  }
}

TEST(TracksFile, RowsMayHaveAnyOrderAndPointsThatComeLaterAreLeftOut) {
  const ScratchFolder scratch;
  const auto file = scratch.write(
      "t.csv", "\xef\xbb\xbfpoint, time_s, x_px, y_px\n7,2,1,1\n7,0,5,6\n3,0,8,9\n9,1,0,0\n3,1,8,10\n");
  const auto read = read_tracks_file(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->points(), 2u);
  EXPECT_EQ(read->at(0, 1), Eigen::Vector2d(8, 10));
  EXPECT_TRUE(read->at(1, 1).hasNaN());
  EXPECT_EQ(read->at(1, 2), Eigen::Vector2d(1, 1));
}

TEST(TracksFile, WrongFilesAreRefusedInOneLine) {
  const ScratchFolder scratch;
  const auto error_of = [&](const std::string& text) {
    const auto read = read_tracks_file(scratch.write("t.csv", text));
    return read ? std::string() : read.error().message;
  };
  EXPECT_NE(error_of("frame,x,y\n").find("line 1 must be the header point,time_s,x_px,y_px"),
            std::string::npos);
  EXPECT_NE(error_of("point,time_s,x_px,y_px\n1,0,nan,2\n").find("line 2, column 3"), std::string::npos);
  EXPECT_NE(error_of("point,time_s,x_px,y_px\n1,0,1,2\n1,1,1,2\n").find("fewer than three times"),
            std::string::npos);
  EXPECT_NE(error_of("point,time_s,x_px,y_px\n1,0,1,2\n1,1,1,2\n1,2,1,2\n1,2,3,4\n").find("two rows at 2 s"),
            std::string::npos);
  EXPECT_NE(error_of("point,time_s,x_px,y_px\n1,-0.1,1,2\n").find("times before 0"), std::string::npos);
  EXPECT_NE(error_of("").find("fewer than three times"), std::string::npos);
}

// A smooth texture that moves by a known part of a pixel.
GreyPicture texture(double x_px, double y_px) {
  GreyPicture picture{96, 80, {}};
  for (int y = 0; y < 80; ++y) {
    for (int x = 0; x < 96; ++x) {
      const double u = x - x_px, v = y - y_px;
      const double shade =
          std::sin(0.45 * u + 0.2 * v) + std::cos(0.33 * v - 0.15 * u) + std::sin(0.21 * u * 0.7);
      picture.pixels.push_back(static_cast<uint8_t>(std::lround(127 + 40 * shade)));
    }
  }
  return picture;
}

// Lucas-Kanade on 8-bit pictures is exact to a few hundredths of a pixel.
TEST(PointTracker, FollowsPartsOfAPixel) {
  std::vector<uint8_t> mask(96 * 80, 0);
  for (int y = 24; y < 56; ++y)
    for (int x = 24; x < 72; ++x) mask[static_cast<size_t>(y * 96 + x)] = 255;
  const GreyPicture first = texture(0, 0);
  const auto corners = trackable_corners(first, mask, 6, 30);
  ASSERT_GE(corners.size(), 8u);
  for (const Eigen::Vector2d& px : corners) {
    EXPECT_GE(px.x(), 24);
    EXPECT_LE(px.x(), 72);
  }
  PointTracker tracker(first, corners);
  for (int frame = 1; frame <= 8; ++frame) {
    const Eigen::Vector2d moved(0.7 * frame, -0.45 * frame);
    const auto& now = tracker.advance(texture(moved.x(), moved.y()));
    for (size_t k = 0; k < corners.size(); ++k)
      EXPECT_LT((now[k] - corners[k] - moved).norm(), 0.1) << "frame " << frame << ", point " << k;
  }
}

// A picture without the texture: every point is lost, and stays so.
TEST(PointTracker, LostPointsAreNotFoundAgain) {
  const std::vector<Eigen::Vector2d> points = {{40.5, 40.5}, {50.5, 30.5}};
  PointTracker tracker(texture(0, 0), points);
  GreyPicture blank{96, 80, std::vector<uint8_t>(96 * 80, 128)};
  for (const Eigen::Vector2d& px : tracker.advance(blank)) EXPECT_TRUE(px.hasNaN());
  for (const Eigen::Vector2d& px : tracker.advance(texture(0, 0))) EXPECT_TRUE(px.hasNaN());
}

TEST(SimulationJournal, KeepsPathsAndRefusesDamagedBytes) {
  PointPaths paths;
  paths.rate_hz = 90;
  paths.points = 2;
  paths.positions_m = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {0.1f, 0.2f, 0.3f}};
  SimulationJournal journal;
  journal.add("first", paths);
  journal.add("empty", PointPaths{});
  paths.points = 4;
  journal.add("second", paths);
  paths.points = 2;
  const auto bytes = journal.bytes();
  SimulationJournal other;
  ASSERT_TRUE(other.read(bytes));
  EXPECT_EQ(other.size(), 2u);
  EXPECT_EQ(other.find("first")->positions_m, paths.positions_m);
  EXPECT_EQ(other.find("first")->rate_hz, 90);
  EXPECT_FALSE(other.find("third"));
  EXPECT_EQ(other.bytes(), bytes);
  for (size_t size = 0; size < bytes.size(); ++size) {
    SimulationJournal damaged;
    const bool whole = damaged.read(std::span(bytes).first(size)).has_value();
    EXPECT_EQ(damaged.size(), whole ? (size > 0 ? 1u : 0u) : 0u) << size;
  }
  std::vector<std::byte> wrong(64, std::byte{0xff});
  EXPECT_FALSE(SimulationJournal().read(wrong));
}

}  // namespace
}  // namespace livegs
