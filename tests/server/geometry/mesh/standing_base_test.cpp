// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/standing_base.h"

#include <gtest/gtest.h>

#include <random>

#include "geometry/mesh/mass_properties.h"
#include "geometry/surface/shape_mesh.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

double lowest_m(const TriangleMesh& mesh) {
  double lowest = INFINITY;
  for (const Vector3d& vertex : mesh.vertices_m) lowest = std::min(lowest, vertex.y());
  return lowest;
}

// A box of w x h x w topples on a slope of w/h.
TEST(StandingBase, MarginOfABoxIsTheSlopeOnWhichItTopples) {
  for (const double height : {0.1, 0.4, 1.0}) {
    const TriangleMesh box = box_mesh(Vector3d(0.2, height, 0.2));
    const auto base = standing_base(box.vertices_m, Vector3d::Zero());
    ASSERT_TRUE(base);
    EXPECT_NEAR(base->margin, 0.2 / height, 1e-12);
    EXPECT_NEAR(base->plane_m, -0.5 * height, 1e-12);
    EXPECT_EQ(base->widened, 1.0);
  }
}

// Threads of haze below a pedestal do not belong to its base.
TEST(StandingBase, PlaneIsAboveHaze) {
  std::mt19937 random(3);
  for (int seed = 0; seed < 20; ++seed) {
    TriangleMesh mesh = cylinder_mesh(0.1, 0.4);
    std::vector<Vector3d> points = mesh.vertices_m;
    const double corner = 0.05 + 0.04 * static_cast<double>(random() % 100) / 100.0;
    for (int i = 0; i < 5; ++i)
      points.push_back({corner, -0.2 - 0.03 * static_cast<double>(random() % 100) / 100.0, 0.01 * i});
    const auto base = standing_base(points, Vector3d::Zero());
    ASSERT_TRUE(base);
    EXPECT_GE(base->margin, kStandingMargin);
    flatten_base(points, *base, Vector3d::Zero());
    for (const Vector3d& point : points) EXPECT_GE(point.y(), base->plane_m - 1e-12);
    EXPECT_NEAR(base->plane_m, -0.2, 0.02);
  }
}

// A cone on its tip gets a base.
TEST(StandingBase, TipIsWidened) {
  TriangleMesh cone = sphere_mesh(0.1, 3);
  for (Vector3d& vertex : cone.vertices_m) {
    const double share = (vertex.y() + 0.1) / 0.2;
    vertex.x() *= share;
    vertex.z() *= share;
    vertex.y() *= 5.0;
  }
  const Vector3d centre = solid_mass_properties(cone).centre_of_mass_m;
  const auto base = standing_base(cone.vertices_m, centre);
  ASSERT_TRUE(base);
  EXPECT_GT(base->widened, 1.0);
  flatten_base(cone.vertices_m, *base, centre);
  EXPECT_NEAR(lowest_m(cone), base->plane_m, 1e-12);
  EXPECT_GT(solid_mass_properties(cone).volume_m3, 0.0);
  const auto again = standing_base(cone.vertices_m, solid_mass_properties(cone).centre_of_mass_m);
  ASSERT_TRUE(again);
  EXPECT_GT(again->margin, 0.8 * kStandingMargin);
}

// The centre of mass of a leaning thing is outside its base.
TEST(StandingBase, BaseMovesUnderALeaningThing) {
  TriangleMesh box = box_mesh(Vector3d(0.1, 0.6, 0.1));
  for (Vector3d& vertex : box.vertices_m) vertex.x() += 0.4 * (vertex.y() + 0.3);
  const Vector3d centre = solid_mass_properties(box).centre_of_mass_m;
  const auto base = standing_base(box.vertices_m, centre);
  ASSERT_TRUE(base);
  flatten_base(box.vertices_m, *base, centre);
  const auto again = standing_base(box.vertices_m, centre);
  ASSERT_TRUE(again);
  EXPECT_GE(again->margin, kStandingMargin);
}

TEST(StandingBase, NothingHasNone) {
  EXPECT_FALSE(standing_base({}, Vector3d::Zero()));
  const std::vector<Vector3d> flat{{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  EXPECT_FALSE(standing_base(flat, Vector3d::Zero()));
}

}  // namespace
}  // namespace livegs
