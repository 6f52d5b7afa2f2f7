// SPDX-License-Identifier: Apache-2.0
#include "skin/drivers/node_neighbours.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace livegs {
namespace {

// Compared with a search over all pairs.
TEST(NodeNeighbours, AreTheLowerIndexedNodesOneCellBelow) {
  std::mt19937 random(4);
  for (int round = 0; round < 20; ++round) {
    std::vector<Eigen::Vector3i> places;
    for (int i = 0; i < 200; ++i)
      places.emplace_back(static_cast<int>(random() % 7) - 3, static_cast<int>(random() % 5) - 2,
                          static_cast<int>(random() % 6) - 1);
    const NodeNeighboursPtr found = find_node_neighbours(places);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->coordinates, places);
    for (uint32_t i = 0; i < places.size(); ++i) {
      std::vector<uint32_t> expected;
      for (int axis = 0; axis < 3; ++axis) {
        uint32_t nearest = 200;
        for (uint32_t k = 0; k < i; ++k) {
          if (places[k] == Eigen::Vector3i(places[i] - Eigen::Vector3i::Unit(axis))) nearest = k;
        }
        if (nearest < 200) expected.push_back(nearest);
      }
      const NodeNeighbours::Before& before = found->before[i];
      ASSERT_EQ(before.count, expected.size());
      expected.resize(3, 200);
      EXPECT_TRUE(std::equal(expected.begin(), expected.end(), before.nodes.begin()));
    }
  }
}

TEST(NodeNeighbours, AreMissingForPlacesOutOfRange) {
  for (const int far : {kMaxNodeCoordinate + 1, -kMaxNodeCoordinate - 1, std::numeric_limits<int>::max(),
                        std::numeric_limits<int>::min()})
    EXPECT_FALSE(find_node_neighbours({{0, 0, 0}, {0, far, 0}})) << far;
  const NodeNeighboursPtr edge =
      find_node_neighbours({{-kMaxNodeCoordinate, -kMaxNodeCoordinate, -kMaxNodeCoordinate},
                            {kMaxNodeCoordinate, kMaxNodeCoordinate, kMaxNodeCoordinate}});
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->before[0].count + edge->before[1].count, 0u);
  EXPECT_TRUE(find_node_neighbours({}));
  EXPECT_TRUE(same_neighbours(find_node_neighbours({{1, 2, 3}}), find_node_neighbours({{1, 2, 3}})));
  EXPECT_FALSE(same_neighbours(find_node_neighbours({{1, 2, 3}}), nullptr));
}

}  // namespace
}  // namespace livegs
