// SPDX-License-Identifier: Apache-2.0
#include "physics/collision/point_surface.h"

#include <gtest/gtest.h>

#include <cmath>

namespace livegs {
namespace {

using Eigen::Vector3d;

// Points `spacing` apart on the faces of a cube of edge 2 about the origin. Edge and corner points occur once
// per face.
std::vector<SurfaceElement> cube_elements(double spacing) {
  std::vector<SurfaceElement> elements;
  const int n = static_cast<int>(std::round(2.0 / spacing));
  for (int d = 0; d < 3; ++d) {
    for (const double side : {-1.0, 1.0}) {
      for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
          Vector3d point = side * Vector3d::Unit(d);
          point[(d + 1) % 3] = -1.0 + i * spacing;
          point[(d + 2) % 3] = -1.0 + j * spacing;
          elements.push_back({point, side * Vector3d::Unit(d), 0.0, static_cast<uint32_t>(elements.size())});
        }
      }
    }
  }
  return elements;
}

// Inside a cube the distance is the smallest distance to a face.
TEST(SurfaceElements, DistanceIsExactUpToCubeEdges) {
  const auto elements = cube_elements(0.25);
  const PointSurface grid(elements, 0.375);
  for (const Vector3d& point :
       {Vector3d(0.98, 0.1, 0.2), {0.93, 0.96, 0.1}, {0.9, -0.95, 0.97}, {0.99, 0.99, 0.2}}) {
    const auto found = grid.depth(point);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->distance_m, point.cwiseAbs().maxCoeff() - 1.0, 1e-12);
    EXPECT_NEAR(found->normal.cwiseAbs().maxCoeff(), 1.0, 1e-12);
  }
}

// A point of a face that approaches from above, slightly beyond the diagonal of the edge.
TEST(SurfaceElements, PointMeetsTheFaceOppositeItsNormal) {
  const auto elements = cube_elements(0.25);
  const PointSurface grid(elements, 0.375);
  const SurfaceElement down{{0.95, 0.9, 0.1}, {0, -1, 0}, 0.0, 0};
  const auto found = grid.depth(down.position_m, {&down, 1});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->distance_m, -0.1, 1e-12);
  EXPECT_NEAR((found->normal - Vector3d::UnitY()).norm(), 0.0, 1e-12);
  const SurfaceElement up{{0.0, 0.9, 0.1}, {0, 1, 0}, 0.0, 0};
  EXPECT_FALSE(grid.depth(up.position_m, {&up, 1})) << "its normal points away from the surface";
  const SurfaceElement outside{{1.05, 0.9, 0.1}, {0, -1, 0}, 0.0, 0};
  EXPECT_GT(grid.depth(outside.position_m, {&outside, 1})->distance_m, 0.0);
}

// A point of a face below the top of the cube enters it through the side. The distance starts at zero and
// ends at that to the top, without a jump.
TEST(SurfaceElements, DistanceIsContinuousWhereAPointPassesAnEdge) {
  const auto elements = cube_elements(0.25);
  const PointSurface grid(elements, 0.375);
  const double step = 1e-4, below = 0.1;
  double last = 0.0;
  for (double inside = step; inside < 2.0 * below; inside += step) {
    const SurfaceElement down{{1.0 - inside, 1.0 - below, 0.1}, {0, -1, 0}, 0.0, 0};
    const auto found = grid.depth(down.position_m, {&down, 1});
    ASSERT_TRUE(found) << inside;
    EXPECT_NEAR((found->normal - Vector3d::UnitY()).norm(), 0.0, 1e-12) << inside;
    EXPECT_NEAR(found->distance_m, last, 20.0 * step) << inside;
    last = found->distance_m;
  }
  EXPECT_NEAR(last, -below, 1e-12);
}

}  // namespace
}  // namespace livegs
