// SPDX-License-Identifier: Apache-2.0
#include "geometry/mesh/mass_properties.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/surface/shape_mesh.h"
#include "server/geometry/mesh/mesh_checks.h"

namespace livegs {
namespace {

using std::numbers::pi;
using testing::moved;

TEST(MassProperties, SolidBoxMatchesItsClosedForm) {
  const Eigen::Vector3d size(0.4, 0.1, 0.2), centre(3.0, -2.0, 1.0);
  const MassProperties box = solid_mass_properties(moved(box_mesh(size), centre));
  const Eigen::Vector3d squares = size.cwiseAbs2();
  const Eigen::Vector3d inertia = (squares.sum() - squares.array()).matrix() / 12.0;
  EXPECT_NEAR(box.volume_m3, 0.008, 1e-15);
  EXPECT_NEAR(box.area_m2, 2 * (0.04 + 0.02 + 0.08), 1e-14);
  EXPECT_TRUE(box.centre_of_mass_m.isApprox(centre, 1e-14));
  EXPECT_TRUE(box.inertia_m2.isApprox(inertia.asDiagonal().toDenseMatrix(), 1e-12));
}

TEST(MassProperties, BoxShellMatchesTheSumOfItsPlates) {
  const Eigen::Vector3d e(0.4, 0.1, 0.2);
  const MassProperties shell = shell_mass_properties(box_mesh(e));
  // A pair of plates normal to axis n lies at e_n/2 and has a variance of e²/12 along the two other axes.
  double area = 0.0;
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
  for (int n = 0; n < 3; ++n) {
    const int u = (n + 1) % 3, v = (n + 2) % 3;
    const double plates = 2 * e[u] * e[v];
    area += plates;
    second[n] += plates * e[n] * e[n] / 4;
    second[u] += plates * e[u] * e[u] / 12;
    second[v] += plates * e[v] * e[v] / 12;
  }
  const Eigen::Vector3d inertia = ((second.sum() - second.array()) / area).matrix();
  EXPECT_TRUE(shell.inertia_m2.isApprox(inertia.asDiagonal().toDenseMatrix(), 1e-12));
}

TEST(MassProperties, SpheresSolidAndHollow) {
  const TriangleMesh mesh = sphere_mesh(0.3, 6);
  const Eigen::Matrix3d unit = 0.09 * Eigen::Matrix3d::Identity();
  // Six subdivisions lack 2e-4 of the volume, and the inertia scales with its 5/3 power.
  EXPECT_TRUE(solid_mass_properties(mesh).inertia_m2.isApprox(0.4 * unit, 5e-4));
  EXPECT_TRUE(shell_mass_properties(mesh).inertia_m2.isApprox(2.0 / 3.0 * unit, 5e-4));
  EXPECT_NEAR(shell_mass_properties(mesh).area_m2, 4 * pi * 0.09, 5e-4 * 4 * pi * 0.09);
}

TEST(MassProperties, AreAccurateFarFromTheOrigin) {
  const TriangleMesh near = sphere_mesh(0.1, 3);
  const MassProperties here = solid_mass_properties(near);
  const MassProperties there = solid_mass_properties(moved(near, {1000, -2000, 500}));
  // Coordinates near 2 km are rounded to 2e-13 m, 4e-12 of the diameter.
  EXPECT_TRUE(there.inertia_m2.isApprox(here.inertia_m2, 1e-10));
  EXPECT_NEAR(there.volume_m3 / here.volume_m3, 1.0, 1e-10);
}

TEST(MassProperties, RotateWithTheBody) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  TriangleMesh mesh = box_mesh({0.4, 0.1, 0.2});
  const Eigen::Matrix3d rest = solid_mass_properties(mesh).inertia_m2;
  for (auto& vertex : mesh.vertices_m) vertex = turn * vertex;
  EXPECT_TRUE(solid_mass_properties(mesh).inertia_m2.isApprox(turn * rest * turn.transpose(), 1e-12));
}

}  // namespace
}  // namespace livegs
