// SPDX-License-Identifier: Apache-2.0
// Frame sizes and kernel errors for four dragged blocks and 200 boxes or fragments, as a regression test.
// `codec_bench` measures the details.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench/support/dragged_blocks.h"
#include "bench/support/kernel_errors.h"
#include "known_gaps.h"
#include "wire/frame_stream.h"

namespace livegs::bench {
namespace {

constexpr double kMaxBytesP95 = 12'000, kMaxMbit_s = 8, kMaxOffset_mm = 0.05;
// Bound of the rotation of 99.9 % of kernels. The others are in crushed cells, where a quantisation step is a
// large rotation (known gap).
constexpr double kMaxTurn_deg = 0.1;
// Positions of poses: half a step of 2^-18 m along each axis. Rotations: components are off by half of sqrt2
// / 2^18. The omitted component, at least 1/2, at most doubles this, and an angle is twice that of the
// quaternion: 2 * 2 * sqrt3 * 2.7e-6 rad = 0.00107 degrees.
constexpr double kMaxPoseOffset_m = 0.5 * 0x1p-18 * 1.7320508 + 1e-9, kMaxPoseTurn_deg = 0.0011;
constexpr size_t kKernelsABlock = 5000, kLookedAtEvery = 45;

// Head of a frame: magic, version, flags, tick (2 bytes up to 16 383), time, elapsed time; also the hash in
// every 32nd frame, and a body without added or removed objects.
constexpr size_t kBytesAsleep = 3 + 2 + 8 + 1 + 4 + 1;

struct Motion {
  double p95 = 0, mbit_s = 0;
  float node_off_m = 0;
  double pose_off_m = 0, pose_off_deg = 0;
  KernelErrors kernels;
  size_t poses = 0;
  // Objects times frames: at rest in two successive frames, and of these, contained in the second frame.
  size_t slept = 0, slept_in_bytes = 0;
};

// Three seconds of dragging, six nightly, of which the first is not counted. With `leave`, then waits until
// all objects sleep.
Motion drag_and_leave(World world, bool leave) {
  Motion motion;
  std::vector<BoundKernels> bound;
  for (uint32_t block = 1; block <= kBlocks; ++block)
    bound.emplace_back(world.rest_body(block), kKernelsABlock, block);
  StreamBaselinePtr baseline;
  StreamReader reader;
  std::vector<double> sizes;
  const size_t objects = world.drivers().objects.size();
  // Distance travelled by each object's first driver.
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
  for (int i = 0; i < 6 * 90; ++i) {
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
  // Checks the motion: blocks are pulled by 0.3 m twice a second, and the other objects fall by half a metre.
  for (size_t k = 0; k < objects; ++k) EXPECT_GT(gone_m[k], k < kBlocks ? 2.0 : 0.4) << "m, object " << k;
  for (const ObjectDrivers& one : frame.objects) motion.poses += one.poses.size();
  double mean = 0;
  for (const double size : sizes) mean += size / static_cast<double>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  motion.p95 = sizes[sizes.size() * 95 / 100];
  motion.mbit_s = mean * 8 * 90 * 1e-6;

  if (!leave) return motion;

  // Without forces, all objects sleep, and frames contain only their head.
  for (uint32_t i = 0; i < kBlocks; ++i) world.clear_spring(i);
  const auto asleep = [&] {
    return static_cast<size_t>(std::count(was_asleep.begin(), was_asleep.end(), true));
  };
  for (int i = 0; i < 12 * 90 && asleep() < objects; ++i) {
    world.step();
    send(frame, shown);
  }
  EXPECT_EQ(asleep(), objects) << "after 12 s";
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
  std::printf("%zu objects at rest in two successive frames; %zu of them were sent\n", motion.slept,
              motion.slept_in_bytes);
  EXPECT_GT(mm.percentile(0.5), 0.0);  // errors were measured
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

TEST(DraggedBytes, BlocksAndBoxesFitANarrowLink) {
  const Motion motion = drag_and_leave(dragged_blocks(), true);
  EXPECT_EQ(motion.poses, static_cast<size_t>(kBoxes));
  hold(motion, "boxes");
  EXPECT_GT(motion.slept, 10'000u);  // enough objects slept for the check of the bytes
}

// Fragments of the project's own fracture. The fragments of one box are one object, which sleeps once all of
// them do, so they are measured while they move.
TEST(DraggedBytes, BlocksAndFragmentsFitANarrowLink) {
  const Motion motion = drag_and_leave(blocks_and_fragments(), false);
  EXPECT_EQ(motion.poses, static_cast<size_t>(kBoxes));
  hold(motion, "fragments");
}

}  // namespace
}  // namespace livegs::bench
