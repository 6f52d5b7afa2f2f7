// SPDX-License-Identifier: Apache-2.0
#include "geometry/surface/shape_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "server/geometry/mesh/mesh_checks.h"

namespace livegs {
namespace {

using std::numbers::pi;
using testing::expect_body;

TEST(ShapeMesh, BoxHasItsExactVolume) {
  const TriangleMesh mesh = box_mesh({0.4, 0.1, 0.2});
  expect_body(mesh);
  EXPECT_EQ(mesh_topology(mesh).euler_characteristic, 2);
  EXPECT_NEAR(signed_volume_m3(mesh), 0.008, 1e-17);
  EXPECT_TRUE(mesh_bounds_m(mesh).sizes().isApprox(Eigen::Vector3d(0.4, 0.1, 0.2)));
}

TEST(ShapeMesh, SphereConvergesQuadratically) {
  const double exact_m3 = 4.0 / 3.0 * pi * 0.008;
  double missing_before = 0.0;
  for (int subdivisions = 0; subdivisions <= 5; ++subdivisions) {
    const TriangleMesh mesh = sphere_mesh(0.2, subdivisions);
    expect_body(mesh);
    EXPECT_EQ(mesh.triangles.size(), 20u << (2 * subdivisions));
    EXPECT_EQ(mesh_topology(mesh).euler_characteristic, 2);
    const double missing = 1.0 - signed_volume_m3(mesh) / exact_m3;
    // For short edges, halving them reduces the missing volume of an inscribed surface to a quarter.
    if (subdivisions > 1) {
      EXPECT_GT(missing_before / missing, 3.5);
    }
    EXPECT_GT(missing, 0.0);
    missing_before = missing;
  }
}

TEST(ShapeMesh, CylinderIsTheInscribedPrism) {
  const TriangleMesh mesh = cylinder_mesh(0.1, 0.5, 24);
  expect_body(mesh);
  EXPECT_EQ(mesh_topology(mesh).euler_characteristic, 2);
  EXPECT_NEAR(signed_volume_m3(mesh), 0.5 * 24 * 0.01 * std::sin(2 * pi / 24) * 0.5, 1e-15);
  EXPECT_NEAR(mesh_bounds_m(mesh).sizes().y(), 0.5, 1e-15);
}

TEST(ShapeMesh, CapsuleHeightIsBetweenItsCapCentres) {
  const TriangleMesh mesh = capsule_mesh(0.1, 0.3, 128);
  expect_body(mesh);
  EXPECT_EQ(mesh_topology(mesh).euler_characteristic, 2);
  EXPECT_NEAR(mesh_bounds_m(mesh).sizes().y(), 0.5, 1e-15);
  // For 128 sides, 1 - sin(x)/x at x = 2 pi / 128 is 0.0004; the caps lack twice that.
  EXPECT_NEAR(signed_volume_m3(mesh) / (pi * 0.01 * 0.3 + 4.0 / 3.0 * pi * 0.001), 1.0, 0.001);
}

}  // namespace
}  // namespace livegs
