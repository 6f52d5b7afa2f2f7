// SPDX-License-Identifier: Apache-2.0
#include "scene/points_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/reconstruct_surface.h"
#include "scratch_folder.h"

namespace livegs {
namespace {

TEST(PointsFile, ReadsPositionsAndVelocitiesInOrder) {
  ScratchFolder folder;
  const auto list =
      read_points_file(folder.write("a.csv", "x,y,z,vx,vy,vz\r\n1,2,3,0,0,-1\n-0.5, 1e-3,4,0,0,2\n"));
  ASSERT_TRUE(list) << list.error().message;
  ASSERT_EQ(list->positions_m.size(), 2u);
  EXPECT_EQ(list->positions_m[1], Eigen::Vector3d(-0.5, 1e-3, 4));
  EXPECT_EQ(list->velocities_m_s[0], Eigen::Vector3d(0, 0, -1));
}

TEST(PointsFile, ErrorsNameFileLineAndColumn) {
  ScratchFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"x;y;z\n1,2,3\n", "line 1"},
      {"x,y,z\n1,2\n", "line 2, column 2"},
      {"x,y,z\n1,2,3,4\n", "line 2, column 3"},
      {"x,y,z\n1,nan,3\n", "column 2"},
      {"x,y,z\n1,2,1e9\n", "column 3"},
      {"x,y,z\n", "no points"},
      {"x,y,z\n1,2,3 metres\n", "line 2"},
      {"", "no points"},
  };
  for (const auto& [text, named] : cases) {
    const auto list = read_points_file(folder.write("b.csv", text));
    ASSERT_FALSE(list) << text;
    EXPECT_NE(list.error().message.find("b.csv"), std::string::npos);
    EXPECT_NE(list.error().message.find(named), std::string::npos) << list.error().message;
  }
}

TEST(PointsFile, MedianSpacingOfAGridIsItsStep) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 10; ++j) {
      for (int k = 0; k < 10; ++k) points.emplace_back(0.01 * i, 0.01 * j, 0.01 * k);
    }
  }
  EXPECT_NEAR(median_spacing_m(points), 0.01, 1e-12);
  EXPECT_EQ(median_spacing_m({Eigen::Vector3d::Zero()}), 0.0);
}

// A block of points fills its cubes, however much each strays from its place by up to 0.3 s: together they must weigh what it
// weighs. Goal: 2 %, as the modulus goes with it.
TEST(PointsFile, AListFillsItsVolumeWhetherRegularOrNot) {
  constexpr double kReached = 0.03, kGoal = 0.02;
  const double s = 0.01;
  for (const Eigen::Vector3i& count : {Eigen::Vector3i(9, 9, 9), Eigen::Vector3i(16, 16, 16), Eigen::Vector3i(32, 8, 8)}) {
    for (const double stray : {0.0, 0.1, 0.2, 0.3}) {
      for (const unsigned seed : {7, 11}) {
        std::mt19937 random(seed);
        const auto offset = [&] { return stray * s * (2.0 * (random() * 0x1p-32) - 1.0); };
        std::vector<Eigen::Vector3d> points;
        for (int k = 0; k < count.z(); ++k) {
          for (int j = 0; j < count.y(); ++j) {
            for (int i = 0; i < count.x(); ++i) points.emplace_back(s * i + offset(), s * j + offset(), s * k + offset());
          }
        }
        const auto surface = reconstruct_surface(points, elastic_surface_options());
        ASSERT_TRUE(surface) << surface.error().message;
        EXPECT_NEAR(std::pow(filling_spacing_m(points, surface->mesh) / s, 3), 1.0, stray > 0 ? kReached : 1e-9)
            << count.transpose() << ", " << stray << ", goal " << kGoal;
      }
    }
  }
}

}  // namespace
}  // namespace livegs
