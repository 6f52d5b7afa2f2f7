// SPDX-License-Identifier: Apache-2.0
// What four torn blocks and 200 boxes take on the wire, and how far off their kernels are shown, so that it is noticed when a
// frame grows or an error does. `codec_bench` tells the rest.
#include <gtest/gtest.h>

#include <algorithm>

#include "bench/dragged_blocks.h"
#include "bench/kernel_errors.h"
#include "wire/frame_stream.h"

namespace livegs::bench {
namespace {

// The best reached, and a little for motions that come out otherwise when the physics change.
constexpr double kMostBytesP95 = 10'500, kMostMbit_s = 6.5, kMostOff_mm = 0.0496;
constexpr double kGoalBytesP95 = 12'000, kGoalMbit_s = 8, kGoalOff_mm = 0.05;
// Of turns the goal is 0.1 degree for all kernels, and is missed. Some are in cells that are crushed, where a step of the grid is a large
// turn: held is what all but a thousandth have, how many turn by more, and of the largest, which hangs on which cell is crushed, little.
constexpr double kMostTurnP999_deg = 0.085, kMostTurn_deg = 4.0, kMostTurned_percent = 0.065, kGoalTurn_deg = 0.1;
constexpr size_t kKernelsABlock = 5000, kLookedAtEvery = 45;

TEST(DraggedBytes, FourTornBlocksAndTwoHundredBoxesFitANarrowLink) {
  World world = dragged_blocks();
  std::vector<BoundKernels> bound;
  for (uint32_t block = 1; block <= kBlocks; ++block) bound.emplace_back(world.rest_body(block), kKernelsABlock, block);
  KernelErrors kernels;
  StreamBaselinePtr baseline;
  StreamReader reader;
  std::vector<double> sizes;
  float off_m = 0;
  // How far each object's first driver went from tick to tick.
  std::vector<double> gone_m(kBlocks + kBoxes, 0);
  std::vector<Eigen::Vector3d> last_m;
  for (int i = 0; i < 540; ++i) {
    drag(world, world.tick());
    world.step();
    const DriverFrame frame = world.drivers();
    const EncodedStreamFrame encoded = encode_stream_frame(frame, baseline);
    baseline = encoded.next;
    const auto read = reader.read(encoded.bytes);
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(frame.objects.size(), gone_m.size());
    ASSERT_EQ(read->objects.size(), gone_m.size());
    std::vector<Eigen::Vector3d> places_m;
    for (const ObjectDrivers& one : read->objects)
      places_m.push_back(one.kind == DriverKind::Rigid ? one.poses.at(0).position_m : one.positions_m.at(0).cast<double>());
    for (size_t k = 0; k < last_m.size(); ++k) gone_m[k] += (places_m[k] - last_m[k]).norm();
    last_m = std::move(places_m);
    if (i < 90) continue;
    sizes.push_back(static_cast<double>(encoded.bytes.size()));
    for (size_t block = 0; block < kBlocks; ++block) {
      const auto &is = frame.objects[block].positions_m, &shown = read->objects[block].positions_m;
      for (size_t k = 0; k < is.size(); ++k) off_m = std::max(off_m, (is[k] - shown[k]).norm());
      if (i % kLookedAtEvery == 0) add_errors(bound[block].pose(frame.objects[block]), bound[block].pose(read->objects[block]), kernels);
    }
  }
  // They are what the figures are said to be of: blocks that are torn about, 0.3 m twice a second, and boxes that fall half a metre.
  for (size_t k = 0; k < gone_m.size(); ++k) EXPECT_GT(gone_m[k], k < kBlocks ? 2.0 : 0.4) << "m, object " << k;
  double mean = 0;
  for (const double size : sizes) mean += size / static_cast<double>(sizes.size());
  std::sort(sizes.begin(), sizes.end());
  const double p95 = sizes[sizes.size() * 95 / 100], mbit_s = mean * 8 * 90 * 1e-6;
  std::printf("p95 %.0f bytes (goal %.0f), %.2f Mbit/s (goal %.0f), nodes at most %.4f mm off (goal %.2f)\n", p95, kGoalBytesP95, mbit_s,
              kGoalMbit_s, 1e3 * static_cast<double>(off_m), kGoalOff_mm);
  const Percentiles &mm = kernels.position_mm, &deg = kernels.rotation_deg;
  std::printf("kernels at most %.4f mm off (goal %.2f); turned by p99 %.4f, p99.9 %.4f, at most %.2f degrees (goal %.1f for all), %.3f %% by more than that\n",
              mm.largest, kGoalOff_mm, deg.percentile(0.99), deg.percentile(0.999), deg.largest, kGoalTurn_deg,
              100 * deg.share_above(kGoalTurn_deg));
  EXPECT_GT(mm.percentile(0.5), 0.0);  // they were looked at
  EXPECT_LE(mm.largest, kGoalOff_mm);
  EXPECT_LE(deg.percentile(0.999), kMostTurnP999_deg) << "degrees; the goal is " << kGoalTurn_deg << " for all";
  EXPECT_LE(deg.largest, kMostTurn_deg) << "degrees, the best reached; the goal is " << kGoalTurn_deg;
  EXPECT_LE(100 * deg.share_above(kGoalTurn_deg), kMostTurned_percent) << "% turn by more than " << kGoalTurn_deg << " degrees, the best reached; the goal is none";
  EXPECT_LE(p95, kMostBytesP95);
  EXPECT_LE(mbit_s, kMostMbit_s);
  EXPECT_LE(1e3 * static_cast<double>(off_m), kMostOff_mm);

  // Left alone, all of it falls asleep, and then costs nothing.
  for (uint32_t i = 0; i < kBlocks; ++i) world.clear_spring(i);
  const auto all_asleep = [&] {
    const DriverFrame frame = world.drivers();
    return std::all_of(frame.objects.begin(), frame.objects.end(), [](const ObjectDrivers& one) { return one.asleep; });
  };
  for (int i = 0; i < 12 * 90 && !(i % 45 == 0 && all_asleep()); ++i) world.step();
  EXPECT_TRUE(all_asleep()) << "within 12 s";
}

}  // namespace
}  // namespace livegs::bench
