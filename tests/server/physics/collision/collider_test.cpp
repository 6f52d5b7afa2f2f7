// SPDX-License-Identifier: Apache-2.0
#include "physics/collider.h"

#include <gtest/gtest.h>

#include <cmath>

namespace livegs {
namespace {

using Eigen::Vector3d;

constexpr double kRounding = 1e-14;  // m, at distances of about 1 m

void expect_sample(const Collider& collider, const Vector3d& point, double distance, const Vector3d& normal) {
  const SurfaceSample sample = sample_surface(collider, point);
  EXPECT_NEAR(sample.distance_m, distance, kRounding);
  EXPECT_NEAR((sample.normal - normal).norm(), 0.0, kRounding);
}

TEST(Collider, PlaneIsSolidBelowItsOrigin) {
  Collider plane;
  plane.shape = PlaneShape{};
  expect_sample(plane, {3, 0.25, -7}, 0.25, Vector3d::UnitY());
  expect_sample(plane, {3, -0.5, 2}, -0.5, Vector3d::UnitY());
  // Rotated by 90 degrees about z, +y becomes -x: the plane is solid on the side of +x, from x = 1.
  plane.world_from_collider = {{1, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(M_PI_2, Vector3d::UnitZ()))};
  expect_sample(plane, {0.25, 5, 5}, 0.75, -Vector3d::UnitX());
}

TEST(Collider, BoxHasFacesEdgesCornersAndDepth) {
  Collider box;
  box.shape = BoxShape{{2, 4, 6}};
  expect_sample(box, {1.5, 1, -2}, 0.5, Vector3d::UnitX());
  expect_sample(box, {-4, -6, 0}, 5.0, Vector3d(-0.6, -0.8, 0));   // edge: 3-4-5
  expect_sample(box, {2, 4, -5}, 3.0, Vector3d(1, 2, -2) / 3.0);   // corner: 1-2-2-3
  expect_sample(box, {0.1, -1.9, 0.5}, -0.1, -Vector3d::UnitY());  // inside: nearest face
  expect_sample(box, {0, 0, 0}, -1.0, Vector3d::UnitX());          // centre: thinnest axis
}

TEST(Collider, SphereIsRadialAndRotatesWithItsPose) {
  Collider sphere;
  sphere.shape = SphereShape{0.5};
  sphere.world_from_collider = {{1, 2, 3},
                                Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()))};
  expect_sample(sphere, {4, 6, 3}, 4.5, Vector3d(0.6, 0.8, 0));
  expect_sample(sphere, {1, 2, 3.25}, -0.25, Vector3d::UnitZ());
  EXPECT_NEAR(sample_surface(sphere, {1, 2, 3}).normal.norm(), 1.0,
              kRounding);  // any unit normal is valid at the centre
}

TEST(Collider, MixesFrictionAndRestitutionOfPairs) {
  EXPECT_DOUBLE_EQ(mixed_friction(0.4, 0.9), 0.6);
  EXPECT_EQ(mixed_friction(0.0, 2.0), 0.0);
  EXPECT_EQ(mixed_restitution(0.1, 0.7), 0.7);
}

}  // namespace
}  // namespace livegs
