// SPDX-License-Identifier: Apache-2.0
// What four torn blocks and 200 boxes or fragments take on the wire, and how far off their kernels are shown,
// so that it is noticed when a frame grows or an error does. `codec_bench` tells the rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench/support/dragged_blocks.h"
#include "bench/support/kernel_errors.h"
#include "known_gaps.h"
#include "wire/frame_stream.h"

namespace livegs::bench {
namespace {

constexpr double kMaxBytesP95 = 12'000, kMaxMbit_s = 8, kMaxOffset_mm = 0.05;
// Turn of a kernel. All but a thousandth keep it; the rest are in crushed cells, where a step of the grid is
// a large turn (known gap).
constexpr double kMaxTurn_deg = 0.1;
// Of poses: half a step of 2^-18 m along each axis. Of turns: components are off by half of sqrt2 / 2^18, the
// one left out, at least 1/2, makes of that twice as much at most, and an angle is twice a quaternion's: 2 *
// 2 * sqrt3 * 2.7e-6 rad = 0.00107 degrees.
constexpr double kMaxPoseOffset_m = 0.5 * 0x1p-18 * 1.7320508 + 1e-9, kMaxPoseTurn_deg = 0.0011;
constexpr size_t kKernelsABlock = 5000, kLookedAtEvery = 45;

// A frame's head: magic, version, flags, tick (2 bytes up to 16 383), time, what has passed; with the hash of
// every 32nd frame, and a body that says of no objects that they are in it and of none that it is gone.
constexpr size_t kBytesAsleep = 3 + 2 + 8 + 1 + 4 + 1;

struct Motion {
  double p95 = 0, mbit_s = 0;
  float node_off_m = 0;
  double pose_off_m = 0, pose_off_deg = 0;
  KernelErrors kernels;
  size_t poses = 0;
  size_t slept = 0, slept_in_bytes = 0;  // objects times frames: at rest in two frames that follow each
                                         // other, and in the bytes of the second
};

// Six seconds of dragging, the first not counted, and then, if they are left, until all are asleep.
Motion drag_and_leave(World world, bool leave) {
  Motion motion;
  std::vector<BoundKernels> bound;
  for (uint32_t block = 1; block <= kBlocks; ++block)
    bound.emplace_back(world.rest_body(block), kKernelsABlock, block);
  StreamBaselinePtr baseline;
  StreamReader reader;
  std::vector<double> sizes;
  const size_t objects = world.drivers().objects.size();
  // How far each object's first driver went from tick to tick.
  std::vector<double> gone_m(objects, 0);
  std::vector<Eigen::Vector3d> last_m;
  std::vector<bool> was_asleep(objects, false);
  const auto send = [&](DriverFrame& frame, DriverFrame& shown) {
    frame = world.drivers();
    const EncodedStreamFrame encoded = encode_stream_frame(frame, baseline);
    baseline = encoded.next;
    auto read = reader.read(encoded.bytes);
    ASSERT_TRUE(read) << read.error().message;
    shown = *std::move(read);
    ASSERT_EQ(frame.objects.size(), objects);
    ASSERT_EQ(shown.objects.size(), objects);
    size_t at_rest = 0;
    for (size_t k = 0; k < objects; ++k) {
      const bool asleep = frame.objects[k].asleep;
      at_rest += asleep && was_asleep[k];
      was_asleep[k] = asleep;
    }
    motion.slept += at_rest;
    if (encoded.object_count > objects - at_rest)
      motion.slept_in_bytes += encoded.object_count - (objects - at_rest);
    sizes.push_back(static_cast<double>(encoded.bytes.size()));
    for (size_t k = 0; k < objects; ++k) {
      const ObjectDrivers &is = frame.objects[k], &has = shown.objects[k];
      for (size_t i = 0; i < is.positions_m.size(); ++i)
        motion.node_off_m = std::max(motion.node_off_m, (is.positions_m[i] - has.positions_m[i]).norm());
      for (size_t i = 0; i < is.poses.size(); ++i) {
        motion.pose_off_m =
            std::max(motion.pose_off_m, (is.poses[i].position_m - has.poses[i].position_m).norm());
        motion.pose_off_deg = std::max(
            motion.pose_off_deg,
            angle_deg(is.poses[i].orientation.cast<float>(), has.poses[i].orientation.cast<float>()));
      }
    }
  };
  DriverFrame frame, shown;
  for (int i = 0; i < 540; ++i) {
    drag(world, world.tick());
    world.step();
    send(frame, shown);
    if (::testing::Test::HasFatalFailure()) return motion;
    std::vector<Eigen::Vector3d> places_m;
    for (const ObjectDrivers& one : shown.objects)
      places_m.push_back(one.kind == DriverKind::Rigid ? one.poses.at(0).position_m
                                                       : one.positions_m.at(0).cast<double>());
    for (size_t k = 0; k < last_m.size(); ++k) gone_m[k] += (places_m[k] - last_m[k]).norm();
    last_m = std::move(places_m);
    if (i < 90) sizes.clear();
    for (size_t block = 0; i >= 90 && i % kLookedAtEvery == 0 && block < kBlocks; ++block)
      add_errors(bound[block].pose(frame.objects[block]), bound[block].pose(shown.objects[block]),
                 motion.kernels);
  }
  // They are what the figures are said to be of: blocks that are torn about, 0.3 m twice a second, and what
  // falls half a metre.
  for (size_t k = 0; k < objects; ++k) EXPECT_GT(gone_m[k], k < kBlocks ? 2.0 : 0.4) << "m, object " << k;
  for (const ObjectDrivers& one : frame.objects) motion.poses += one.poses.size();
  double mean = 0;
  for (const double size : sizes) mean += size / static_cast<double>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  motion.p95 = sizes[sizes.size() * 95 / 100];
  motion.mbit_s = mean * 8 * 90 * 1e-6;

  if (!leave) return motion;

  // Left alone, all of it falls asleep, and then costs nothing but the head of a frame.
  for (uint32_t i = 0; i < kBlocks; ++i) world.clear_spring(i);
  const auto asleep = [&] {
    return static_cast<size_t>(std::count(was_asleep.begin(), was_asleep.end(), true));
  };
  for (int i = 0; i < 12 * 90 && asleep() < objects; ++i) {
    world.step();
    send(frame, shown);
  }
  EXPECT_EQ(asleep(), objects) << "within 12 s";
  sizes.clear();
  const size_t slept_before = motion.slept;
  for (int i = 0; i < 90; ++i) {
    world.step();
    send(frame, shown);
  }
  EXPECT_EQ(motion.slept - slept_before, 90 * objects);
  EXPECT_LE(*std::max_element(sizes.begin(), sizes.end()), kBytesAsleep);
  return motion;
}

void hold(const Motion& motion, const char* what) {
  std::printf(
      "%s: p95 %.0f bytes (bar %.0f), %.2f Mbit/s (bar %.0f), nodes at most %.4f mm off (bar %.2f), %zu "
      "poses %.4f mm and %.4f degrees\n",
      what, motion.p95, kMaxBytesP95, motion.mbit_s, kMaxMbit_s, 1e3 * static_cast<double>(motion.node_off_m),
      kMaxOffset_mm, motion.poses, 1e3 * motion.pose_off_m, motion.pose_off_deg);
  const Percentiles &mm = motion.kernels.position_mm, &deg = motion.kernels.rotation_deg;
  std::printf(
      "kernels at most %.4f mm off (bar %.2f); turned by p99 %.4f, p99.9 %.4f, at most %.2f degrees (bar "
      "%.1f for all), %.3f %% by more than that\n",
      mm.largest, kMaxOffset_mm, deg.percentile(0.99), deg.percentile(0.999), deg.largest, kMaxTurn_deg,
      100 * deg.share_above(kMaxTurn_deg));
  std::printf("of %zu objects in frames that were at rest in that before, %zu were sent\n", motion.slept,
              motion.slept_in_bytes);
  EXPECT_GT(mm.percentile(0.5), 0.0);  // they were looked at
  EXPECT_LE(mm.largest, kMaxOffset_mm);
  EXPECT_LE(deg.percentile(0.999), kMaxTurn_deg) << "degrees";
  report_gap("dragged.kernel_turn_deg", deg.largest);
  report_gap("dragged.kernels_turned_percent", 100 * deg.share_above(kMaxTurn_deg));
  EXPECT_LE(motion.p95, kMaxBytesP95);
  EXPECT_LE(motion.mbit_s, kMaxMbit_s);
  EXPECT_LE(1e3 * static_cast<double>(motion.node_off_m), kMaxOffset_mm);
  EXPECT_LE(motion.pose_off_m, kMaxPoseOffset_m);
  EXPECT_LE(motion.pose_off_deg, kMaxPoseTurn_deg);
  EXPECT_EQ(motion.slept_in_bytes, 0u);
}

TEST(DraggedBytes, FourTornBlocksAndTwoHundredBoxesFitANarrowLink) {
  const Motion motion = drag_and_leave(dragged_blocks(), true);
  EXPECT_EQ(motion.poses, static_cast<size_t>(kBoxes));
  hold(motion, "boxes");
  EXPECT_GT(motion.slept, 10'000u);  // nothing was sent of what there was, not for want of it
}

// Of things that the project's own fracture broke. The fragments of one are one object, which sleeps when all
// of them do: they are looked at while they move.
TEST(DraggedBytes, SoDoTwoHundredFragments) {
  const Motion motion = drag_and_leave(blocks_and_fragments(), false);
  EXPECT_EQ(motion.poses, static_cast<size_t>(kBoxes));
  hold(motion, "fragments");
}

}  // namespace
}  // namespace livegs::bench
