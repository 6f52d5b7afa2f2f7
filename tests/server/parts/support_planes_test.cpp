// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/planes/support_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace livegs {
namespace {

// A level table of 1 m x 0.8 m at a height of 0.7 m, a floor and a wall behind, with noise across each.
std::vector<ViewPoint> table_room(double noise_m) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  std::normal_distribution<double> normal(0, noise_m);
  std::vector<ViewPoint> points;
  const auto add = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    ViewPoint point;
    point.position_m = (p + normal(random) * n).cast<float>();
    point.normal = n.cast<float>();
    point.footprint_m = 0.003f;
    points.push_back(point);
  };
  for (int i = 0; i < 4000; ++i) add({uniform(-0.5, 0.5), 0.7, uniform(-0.4, 0.4)}, Eigen::Vector3d::UnitY());
  for (int i = 0; i < 6000; ++i) add({uniform(-2, 2), 0, uniform(-2, 2)}, Eigen::Vector3d::UnitY());
  for (int i = 0; i < 5000; ++i) add({uniform(-2, 2), uniform(0, 2), -2}, Eigen::Vector3d::UnitZ());
  return points;
}

TEST(SupportPlanes, FindsTableFloorAndWall) {
  const double noise_m = 0.001;
  const RoomPlanes planes =
      find_planes(table_room(noise_m), Eigen::Vector3d(0.1, 1, 0.1).normalized(), 0.003);
  ASSERT_EQ(planes.supports.size(), 2u);
  ASSERT_EQ(planes.walls.size(), 1u);
  // The mean of 4000 points is good to noise / sqrt(4000); ten times that for truncation by the inliers.
  const double tolerance_m = 10 * noise_m / std::sqrt(4000.0);
  EXPECT_NEAR(planes.supports[0].height_m({0, 0.7, 0}), 0, tolerance_m);
  EXPECT_NEAR(planes.supports[1].height_m({0, 0, 0}), 0, tolerance_m);
  EXPECT_NEAR(planes.walls[0].height_m({0, 1, -2}), 0, tolerance_m);
  EXPECT_NEAR(planes.supports[0].share, 4.0 / 15, 0.01);
  EXPECT_NEAR(planes.supports[0].deviation_m, noise_m, 0.2 * noise_m);
  EXPECT_NEAR(planes.supports[0].region.area_m2(), 0.8, 0.1);
}

TEST(SupportPlanes, RegionFillsTheHoleUnderAThing) {
  std::vector<Eigen::Vector3f> ring;
  for (int x = -20; x <= 20; ++x)
    for (int z = -20; z <= 20; ++z)
      if (x * x + z * z > 64)
        ring.emplace_back(0.01f * static_cast<float>(x), 0.0f, 0.01f * static_cast<float>(z));
  const PlaneRegion region(Eigen::Vector3d::UnitY(), 0.01, ring);
  EXPECT_TRUE(region.contains({0, 0.3, 0}));
  EXPECT_FALSE(region.seen({0, 0, 0}));
  EXPECT_TRUE(region.seen({0.15, 0, 0}));
  EXPECT_FALSE(region.contains({0.3, 0, 0}));
}

TEST(SupportPlanes, RegionReachesToAHiddenCorner) {
  std::vector<Eigen::Vector3f> floor;  // without a triangle at the corner (0, 0)
  for (int x = 0; x <= 40; ++x)
    for (int z = 0; z <= 40; ++z)
      if (x + z > 20) floor.emplace_back(0.01f * static_cast<float>(x), 0.0f, 0.01f * static_cast<float>(z));
  const Eigen::Vector3f corner = Eigen::Vector3f::Zero();
  const Eigen::Vector3d hidden(0.03, 0.2, 0.03);
  EXPECT_FALSE(PlaneRegion(Eigen::Vector3d::UnitY(), 0.01, floor).contains(hidden));
  EXPECT_TRUE(PlaneRegion(Eigen::Vector3d::UnitY(), 0.01, floor, {&corner, 1}).contains(hidden));
}

TEST(SupportPlanes, NothingIsFoundInNoise) {
  EXPECT_TRUE(find_planes({}, Eigen::Vector3d::UnitY(), 0.003).supports.empty());
}

}  // namespace
}  // namespace livegs
