// SPDX-License-Identifier: Apache-2.0
#include "physics/collision/bounding_sphere_tree.h"

#include <gtest/gtest.h>

#include <random>

namespace livegs {
namespace {

using Eigen::Vector3d;

// Compared with a plain loop: all points within reach are found in their original order, and most distant
// points are skipped.
TEST(BoundingSphereTree, FindsAllPointsNearAPlane) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> along(-1.0, 1.0);
  std::vector<Vector3d> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(along(random), along(random), along(random));
  points.resize(1003, Vector3d(0.1, 0.2, 0.3));  // several coincident points
  const BoundingSphereTree tree(points);
  for (int turn = 0; turn < 20; ++turn) {
    const Vector3d normal = Vector3d(along(random), along(random), along(random)).normalized();
    const double offset = along(random), reach = 0.05;
    const auto clearance = [&](const Vector3d& point) { return normal.dot(point) - offset; };
    std::vector<uint32_t> found{7};  // existing entries stay first
    tree.near(clearance, reach, found);
    EXPECT_TRUE(std::is_sorted(found.begin() + 1, found.end()));
    size_t within = 0;
    for (uint32_t i = 0; i < points.size(); ++i) {
      if (clearance(points[i]) > reach) continue;
      ++within;
      EXPECT_TRUE(std::binary_search(found.begin() + 1, found.end(), i)) << i;
    }
    EXPECT_LE(found.size(), 1.3 * static_cast<double>(within) + 60.0);
  }
}

TEST(BoundingSphereTree, EmptyTreeFindsNothing) {
  std::vector<uint32_t> found;
  BoundingSphereTree(std::vector<Vector3d>{}).near([](const Vector3d&) { return -1.0; }, 1.0, found);
  BoundingSphereTree().near([](const Vector3d&) { return -1.0; }, 1.0, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace livegs
