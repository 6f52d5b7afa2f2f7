// SPDX-License-Identifier: GPL-3.0-or-later
#include "physics/collision/surface_points.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

#include "geometry/surface/shape_mesh.h"

namespace livegs {
namespace {

using Eigen::Vector3d;

// Largest distance of the patches along a direction: the support function of the shape that they touch with.
double support_m(const std::vector<SurfacePatch>& patches, const Vector3d& direction) {
  double most = -INFINITY;
  for (const SurfacePatch& patch : patches) {
    const Vector3d point = patch.rest_m + touching_offset(patch, -direction);
    most = std::max(most, direction.dot(point));
  }
  return most;
}

// Spread of the support function about its closed form, over directions all round.
std::pair<double, double> support_errors(const ParticleSet& particles,
                                         const std::function<double(const Vector3d&)>& exact_m) {
  const std::vector<SurfacePatch> patches = surface_patches(particles);
  double low = INFINITY, high = -INFINITY;
  for (int i = 0; i < 1000; ++i) {  // Fibonacci points
    const double y = 1.0 - (2.0 * i + 1.0) / 1000.0, across = std::sqrt(1.0 - y * y), turn = 2.39996 * i;
    const Vector3d direction(across * std::cos(turn), y, across * std::sin(turn));
    const double error = support_m(patches, direction) - exact_m(direction);
    low = std::min(low, error);
    high = std::max(high, error);
  }
  return {low, high};
}

TEST(SurfacePatches, SphereTouchesLikeASphere) {
  const auto [low, high] =
      support_errors(sample_particles(sphere_mesh(0.1, 3)), [](const Vector3d&) { return 0.1; });
  EXPECT_GT(low, -2e-4);  // 0.2 % of the radius
  EXPECT_LT(high, 2e-4);
}

TEST(SurfacePatches, CylinderTouchesLikeACylinder) {
  const auto [low, high] = support_errors(sample_particles(cylinder_mesh(0.1, 0.2)), [](const Vector3d& d) {
    return 0.1 * std::hypot(d.x(), d.z()) + 0.1 * std::abs(d.y());
  });
  EXPECT_GT(low, -2e-4);
  EXPECT_LT(high, 2e-4);
}

TEST(SurfacePatches, BoxTouchesAtItsCorners) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.4, Vector3d(1.0, 2.0, -1.0).normalized()));
  TriangleMesh mesh = box_mesh({0.1, 0.06, 0.2});
  for (Vector3d& vertex : mesh.vertices_m) vertex = turn * vertex;
  const auto [low, high] = support_errors(sample_particles(mesh), [&](const Vector3d& d) {
    return (turn.conjugate() * d).cwiseAbs().dot(Vector3d(0.05, 0.03, 0.1));
  });
  EXPECT_GT(low, -1e-9);  // each corner is a point, in any lattice
  EXPECT_LT(high, 1e-9);
}

}  // namespace
}  // namespace livegs
