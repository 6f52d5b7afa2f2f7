// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <numbers>

#include "stream/received/frame_history.h"

namespace livegs {
namespace {

// A rigid object 1 at x = tick, rotated by tick * 0.1 rad about y, and a lattice 2 with two nodes.
DriverFrame frame(uint64_t tick) {
  const auto at = static_cast<double>(tick);
  DriverFrame made;
  made.tick = tick;
  made.simulated_ns = static_cast<int64_t>(tick) * 10'000'000;
  ObjectDrivers rigid;
  rigid.object_id = 1;
  rigid.poses = {{{at, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(0.1 * at, Eigen::Vector3d::UnitY()))}};
  ObjectDrivers lattice;
  lattice.object_id = 2;
  lattice.kind = DriverKind::Lattice;
  lattice.positions_m = {{static_cast<float>(at), 0, 0}, {0, static_cast<float>(2 * at), 0}};
  made.objects = {rigid, lattice};
  return made;
}

TEST(FrameHistory, InterpolatesBetweenAdjacentFrames) {
  FrameHistory history(8);
  for (uint64_t tick : {1, 2, 4}) history.add(frame(tick));
  const auto between = history.at(32'500'000);  // 5/8 between ticks 2 and 4
  ASSERT_TRUE(between);
  EXPECT_NEAR(between->objects[0].poses[0].position_m.x(), 3.25, 1e-12);
  EXPECT_NEAR(between->objects[1].positions_m[1].y(), 6.5f, 1e-6f);
  // Lerp along the chord is slower at its ends than slerp: over 0.2 rad they differ by less than 0.1 mrad.
  const Eigen::AngleAxisd turn(between->objects[0].poses[0].orientation);
  EXPECT_NEAR(turn.angle(), 0.325, 1e-4);
  EXPECT_EQ(between->simulated_ns, 32'500'000);
}

TEST(FrameHistory, ReturnsStoredFramesExactly) {
  FrameHistory history(8);
  for (uint64_t tick : {1, 2, 3}) history.add(frame(tick));
  const auto exact = history.at(20'000'000);
  ASSERT_TRUE(exact);
  EXPECT_EQ(exact->tick, 2u);
  EXPECT_EQ(exact->objects[0].poses[0].position_m.x(), 2.0);
}

TEST(FrameHistory, HoldsPoseBeforeOldestFrame) {
  FrameHistory history(8);
  EXPECT_FALSE(history.at(0));
  history.add(frame(3));
  EXPECT_EQ(history.at(1'000'000'000)->tick, 3u);
  history.add(frame(4));
  EXPECT_EQ(history.at(0)->tick, 3u);
}

// A server omits frames at rest: the motion begins a tick before the next frame, not at the last one.
TEST(FrameHistory, RepeatsAFrameAtRestUntilTheNext) {
  FrameHistory history(8);
  const auto resting = [](uint64_t tick) {
    DriverFrame made = frame(2);
    made.tick = tick;
    made.simulated_ns = static_cast<int64_t>(tick) * 10'000'000;
    return made;
  };
  EXPECT_FALSE(history.add(resting(2)));
  EXPECT_FALSE(history.add(resting(3)));
  EXPECT_EQ(history.add(frame(20)), 190'000'000);
  const auto x_m = [&](int64_t simulated_ns) {
    return history.at(simulated_ns)->objects[0].poses[0].position_m.x();
  };
  EXPECT_EQ(x_m(100'000'000), 2.0);
  EXPECT_EQ(x_m(190'000'000), 2.0);
  EXPECT_NEAR(x_m(195'000'000), 11.0, 1e-12);
  EXPECT_EQ(x_m(200'000'000), 20.0);
  // Without rest, a missing frame is interpolated.
  EXPECT_FALSE(history.add(frame(22)));
  EXPECT_NEAR(x_m(210'000'000), 21.0, 1e-12);
}

TEST(FrameHistory, ExtrapolatesForTwoFramesThenStops) {
  FrameHistory history(8);
  for (uint64_t tick : {1, 2, 4})
    history.add(frame(tick));  // 3 was dropped: the last two frames are two intervals apart
  const auto beyond = history.at(55'000'000);
  EXPECT_NEAR(beyond->objects[0].poses[0].position_m.x(), 5.5, 1e-9);
  EXPECT_NEAR(beyond->objects[1].positions_m[1].y(), 11.0f, 1e-5f);
  // On the chord of 0.2 rad, 1.75 of its length from its start: atan(2.5 tan 0.1) + 0.3.
  EXPECT_NEAR(Eigen::AngleAxisd(beyond->objects[0].poses[0].orientation).angle(),
              0.3 + 2 * std::atan(2.5 * std::tan(0.05)), 1e-9);
  EXPECT_EQ(beyond->simulated_ns, 55'000'000);
  const auto stands = history.at(1'000'000'000);
  EXPECT_NEAR(stands->objects[0].poses[0].position_m.x(), 6.0, 1e-9);
  EXPECT_EQ(stands->simulated_ns, 60'000'000);
}

TEST(FrameHistory, DoesNotExtrapolateSleepingOrFracturedObjects) {
  FrameHistory history(8);
  DriverFrame later = frame(2);
  later.objects[0].asleep = true;
  later.objects[1].revision = 1;
  history.add(frame(1));
  history.add(later);
  const auto beyond = history.at(30'000'000);
  EXPECT_EQ(beyond->objects[0].poses[0].position_m.x(), 2.0);
  EXPECT_EQ(beyond->objects[1].positions_m[1].y(), 4.0f);
  EXPECT_EQ(beyond->objects[1].revision, 1u);
}

// A fracture between two frames: whole until the later frame, then as in the later frame.
TEST(FrameHistory, DoesNotInterpolateAcrossFracture) {
  FrameHistory history(8);
  DriverFrame broken = frame(2);
  broken.objects[0].revision = 1;
  broken.objects[0].poses.push_back(Pose{});
  history.add(frame(1));
  history.add(broken);
  for (const int64_t moment : {11'000'000, 15'000'000, 19'999'999}) {
    const auto whole = history.at(moment);
    EXPECT_EQ(whole->objects[0].revision, 0u);
    EXPECT_EQ(whole->objects[0].poses.size(), 1u);
    EXPECT_EQ(whole->objects[0].poses[0].position_m.x(), 1.0);
  }
  EXPECT_EQ(history.at(20'000'000)->objects[0].revision, 1u);
  EXPECT_EQ(history.at(28'000'000)->objects[0].poses[0].position_m.x(), 2.0);
}

TEST(FrameHistory, RestingObjectsStayBitIdentical) {
  DriverFrame a = frame(1), b = frame(2);
  a.objects[0].poses[0].orientation =
      Eigen::Quaterniond(0.3, 0.4, -0.5, 0.6);  // not exactly unit, as from a decoder
  b.objects[0].poses = a.objects[0].poses;
  const DriverFrame between = interpolate(a, b, 0.37);
  EXPECT_EQ(between.objects[0].poses[0].orientation.coeffs(), a.objects[0].poses[0].orientation.coeffs());
  EXPECT_EQ(between.objects[0].poses[0].position_m, a.objects[0].poses[0].position_m);
}

TEST(FrameHistory, RotatesAlongShorterArc) {
  DriverFrame a = frame(1), b = frame(2);
  b.objects[0].poses[0].orientation.coeffs() *= -1;  // the same rotation
  const DriverFrame between = interpolate(a, b, 0.5);
  EXPECT_NEAR(Eigen::AngleAxisd(between.objects[0].poses[0].orientation).angle(), 0.15, 1e-6);
}

TEST(FrameHistory, IsBoundedAndIgnoresOldFrames) {
  FrameHistory history(4);
  for (uint64_t tick = 1; tick <= 100; ++tick) history.add(frame(tick));
  history.add(frame(50));
  EXPECT_EQ(history.size(), 4u);
  EXPECT_EQ(history.oldest().tick, 97u);
  EXPECT_EQ(history.newest().tick, 100u);
}

TEST(FrameHistory, DroppingKeepsNeededFrames) {
  FrameHistory history(8);
  for (uint64_t tick : {1, 2, 3, 4}) history.add(frame(tick));
  const auto before = history.at(25'000'000);
  history.drop_before(25'000'000);
  EXPECT_EQ(history.size(), 3u);
  EXPECT_EQ(history.at(25'000'000)->objects[0].poses[0].position_m, before->objects[0].poses[0].position_m);
}

TEST(FrameHistory, ObjectAppearsAndDisappearsAtItsFrames) {
  DriverFrame with = frame(2);
  ObjectDrivers ball;
  ball.object_id = 9;
  ball.poses = {Pose{}};
  with.objects.push_back(ball);
  EXPECT_EQ(interpolate(frame(1), with, 0.5).objects.size(), 2u);
  EXPECT_EQ(interpolate(with, frame(3), 0.5).objects.size(), 3u);
}

TEST(FrameHistory, ChangedDriversUseEarlierFrame) {
  DriverFrame broken = frame(2);
  broken.objects[0].poses.push_back(Pose{});  // two fragments
  const DriverFrame between = interpolate(frame(1), broken, 0.5);
  EXPECT_EQ(between.objects[0].poses.size(), 1u);
  EXPECT_EQ(between.objects[0].poses[0].position_m.x(), 1.0);
}

}  // namespace
}  // namespace livegs
