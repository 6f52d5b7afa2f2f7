// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/triangulate_polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>
#include <random>

namespace livegs {
namespace {

double area_of(const std::vector<std::array<uint32_t, 3>>& triangles, std::span<const Eigen::Vector2d> points,
               bool absolute) {
  double area = 0.0;
  for (const auto& triangle : triangles) {
    const double twice = twice_area({triangle[0], triangle[1], triangle[2]}, points);
    area += 0.5 * (absolute ? std::abs(twice) : twice);
  }
  return area;
}

void expect_boundary(const PolygonRegion& region, const std::vector<std::array<uint32_t, 3>>& triangles) {
  std::map<std::pair<uint32_t, uint32_t>, int> balance;
  const auto add = [&](uint32_t from, uint32_t to, int sign) {
    if (from != to) balance[std::minmax(from, to)] += from < to ? sign : -sign;
  };
  for (const auto& [a, b, c] : triangles) add(a, b, 1), add(b, c, 1), add(c, a, 1);
  for (const auto& loop : region.loops) {
    for (size_t i = 0; i < loop.size(); ++i) add(loop[i], loop[(i + 1) % loop.size()], -1);
  }
  for (const auto& [edge, count] : balance) EXPECT_EQ(count, 0) << edge.first << " - " << edge.second;
}

// Jagged stars with jagged holes, with additional points in the middle of edges.
TEST(TriangulatePolygon, CoversJaggedPolygonsWithHolesExactlyOnce) {
  std::mt19937 engine(3);
  for (int n = 0; n < 200; ++n) {
    std::vector<Eigen::Vector2d> points;
    std::vector<std::vector<uint32_t>> loops;
    const auto star = [&](Eigen::Vector2d middle, double size, bool hole) {
      std::vector<uint32_t> loop;
      const int corners = 5 + static_cast<int>(engine() % 20);
      std::vector<Eigen::Vector2d> round;
      for (int c = 0; c < corners; ++c) {
        const double turn = 2 * std::numbers::pi * (hole ? -c : c) / corners;
        const double radius = size * (0.3 + 0.7 * static_cast<double>(engine() % 1000) / 1000);
        round.emplace_back(middle + radius * Eigen::Vector2d(std::cos(turn), std::sin(turn)));
      }
      for (int c = 0; c < corners; ++c) {
        loop.push_back(static_cast<uint32_t>(points.size()));
        points.push_back(round[c]);
        loop.push_back(static_cast<uint32_t>(points.size()));
        points.push_back(0.5 * (round[c] + round[(c + 1) % corners]));
      }
      loops.push_back(loop);
    };
    star({0, 0}, 10, false);
    for (int hole = 0; hole < n % 4; ++hole) {
      const double turn = 2 * std::numbers::pi * hole / 3;
      star(1.2 * Eigen::Vector2d(std::cos(turn), std::sin(turn)), 0.7, true);
    }
    double expected = 0.0;
    for (const auto& loop : loops) expected += 0.5 * twice_area(loop, points);
    const std::vector<PolygonRegion> regions = nest_loops(loops, points);
    ASSERT_EQ(regions.size(), 1u);
    ASSERT_EQ(regions[0].loops.size(), loops.size());
    const auto triangles = triangulate(regions[0], points);
    EXPECT_NEAR(area_of(triangles, points, false), expected, 1e-12 * expected);
    EXPECT_NEAR(area_of(triangles, points, true), expected, 1e-12 * expected);  // no triangle is inverted
    expect_boundary(regions[0], triangles);
  }
}

TEST(TriangulatePolygon, KeepsTheBoundaryOfPolygonsThatAreNotSimple) {
  std::mt19937 engine(4);
  for (int n = 0; n < 100; ++n) {
    std::vector<Eigen::Vector2d> points(12);
    for (auto& point : points) point = {static_cast<double>(engine() % 4), static_cast<double>(engine() % 4)};
    PolygonRegion region{{{0, 1, 2, 3, 4, 5, 6, 7}, {8, 9, 10, 11}}};
    const auto triangles = triangulate(region, points);
    expect_boundary(region, triangles);
    EXPECT_NEAR(area_of(triangles, points, false),
                0.5 * (twice_area(region.loops[0], points) + twice_area(region.loops[1], points)), 1e-12);
  }
}

}  // namespace
}  // namespace livegs
