// SPDX-License-Identifier: GPL-3.0-or-later
#include "parts/graph/kernel_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace livegs {
namespace {

std::vector<Eigen::Vector3f> cloud(size_t count, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3f> points;
  for (size_t i = 0; i < count; ++i)  // a coarse lattice, so that points coincide and distances tie
    points.emplace_back(static_cast<float>(random() % 17), static_cast<float>(random() % 5),
                        static_cast<float>(random() % 9));
  return points;
}

TEST(KernelTree, NearestEqualsASortOfAllDistances) {
  for (const size_t count : {1u, 2u, 12u, 13u, 25u, 500u}) {
    const auto points = cloud(count, count);
    const KernelTree tree(points);
    std::vector<KernelTree::Neighbour> found, all;
    for (const Eigen::Vector3f& at : cloud(20, 99)) {
      all.clear();
      for (uint32_t i = 0; i < count; ++i) all.push_back({(points[i] - at).squaredNorm(), i});
      std::sort(all.begin(), all.end());
      for (const float radius : {std::numeric_limits<float>::infinity(), 2.0f, 0.0f}) {
        tree.nearest(at, 7, found, radius);
        const auto near = std::count_if(all.begin(), all.end(),
                                        [&](const auto& one) { return one.distance2 <= radius * radius; });
        ASSERT_EQ(found.size(), std::min<size_t>(7, static_cast<size_t>(near)));
        for (size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].distance2, all[i].distance2) << count;
      }
    }
  }
}

TEST(KernelTree, WithinFindsAllPointsOfABall) {
  const auto points = cloud(400, 3);
  const KernelTree tree(points);
  std::vector<uint32_t> found;
  for (const Eigen::Vector3f& at : cloud(10, 4)) {
    tree.within(at, 3.0f, found);
    std::sort(found.begin(), found.end());
    std::vector<uint32_t> expected;
    for (uint32_t i = 0; i < points.size(); ++i)
      if ((points[i] - at).squaredNorm() <= 9.0f) expected.push_back(i);
    EXPECT_EQ(found, expected);
  }
}

TEST(KernelTree, EmptyTreeFindsNothing) {
  const KernelTree tree(std::vector<Eigen::Vector3f>{});
  std::vector<KernelTree::Neighbour> found;
  tree.nearest({0, 0, 0}, 3, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace livegs
