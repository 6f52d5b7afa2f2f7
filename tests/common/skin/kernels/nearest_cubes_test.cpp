// SPDX-License-Identifier: Apache-2.0
#include "skin/kernels/nearest_cubes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "common/skin/kernels/rest_bodies.h"

namespace livegs {
namespace {

using namespace livegs::testing;

void expect_same_as_all_pairs(const std::vector<Eigen::Vector3f>& centres, float half_width,
                              const std::vector<Eigen::Vector3f>& points) {
  const NearestCubes cubes(centres, half_width);
  for (const Eigen::Vector3f& point : points) {
    std::vector<std::pair<float, uint32_t>> all;
    for (uint32_t i = 0; i < centres.size(); ++i) {
      all.emplace_back(((point - centres[i]).array().abs() - half_width).max(0.0f).matrix().squaredNorm(), i);
    }
    std::sort(all.begin(), all.end());
    std::array<NearestCubes::Neighbour, 4> nearest;
    const size_t found = cubes.find(point, nearest);
    ASSERT_EQ(found, std::min<size_t>(4, centres.size()));
    for (size_t i = 0; i < found; ++i) {
      EXPECT_EQ(nearest[i].distance_squared, all[i].first);
      EXPECT_EQ(nearest[i].index, all[i].second);
    }
  }
}

std::vector<Eigen::Vector3f> random_points(size_t count, const Eigen::Vector3d& extent, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3f> points;
  for (size_t i = 0; i < count; ++i)
    points.push_back(uniform3(random, -1, 1).cwiseProduct(extent).cast<float>());
  return points;
}

TEST(NearestCubes, MatchBruteForceForEveryKindOfSet) {
  const std::vector<Eigen::Vector3d> extents = {{1, 1, 1}, {1, 1, 0}, {1, 0, 0}, {0, 0, 0}, {1, 1e-3, 10}};
  for (const Eigen::Vector3d& extent : extents) {
    for (const size_t count : {1u, 3u, 700u}) {
      const std::vector<Eigen::Vector3f> centres = random_points(count, extent, 1);
      std::vector<Eigen::Vector3f> points = random_points(100, {2, 2, 2}, 2);
      const std::vector<Eigen::Vector3f> far = random_points(20, {1e4, 1e4, 1e4}, 3);
      points.insert(points.end(), far.begin(), far.end());
      for (const float half_width : {0.0f, 0.05f, 1.0f})
        expect_same_as_all_pairs(centres, half_width, points);
    }
  }
}

TEST(NearestCubes, TiesAreInIndexOrder) {
  const std::vector<Eigen::Vector3f> centres = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                                {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
  const NearestCubes cubes(centres, 0.0f);
  std::array<NearestCubes::Neighbour, 3> nearest;
  ASSERT_EQ(cubes.find({0, 0, 0}, nearest), 3u);
  EXPECT_EQ(nearest[0].index, 0u);
  EXPECT_EQ(nearest[1].index, 1u);
  EXPECT_EQ(nearest[2].index, 2u);
}

}  // namespace
}  // namespace livegs
