// SPDX-License-Identifier: Apache-2.0
#include "geometry/field/sample_particles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "geometry/mesh/mass_properties.h"
#include "geometry/surface/shape_mesh.h"
#include "server/geometry/mesh/mesh_checks.h"

namespace livegs {
namespace {

double volume_sum(const ParticleSet& set) {
  return std::accumulate(set.volumes_m3.begin(), set.volumes_m3.end(), 0.0);
}

TEST(SampleParticles, BarHasVoxelCentresAndCorners) {
  const ParticleSet set = sample_particles(box_mesh({0.4, 0.1, 0.1}), kDefaultSamplingDensity, 0.025);
  EXPECT_DOUBLE_EQ(set.spacing_m, 0.025);
  // 16 x 4 x 4 voxel centres, then the corners, each half a diagonal from the nearest centre.
  ASSERT_EQ(set.positions_m.size(), 16u * 4u * 4u + 8u);
  EXPECT_EQ(std::count(set.on_surface.begin(), set.on_surface.end(), true), 8);
  EXPECT_TRUE(set.positions_m[0].isApprox(Eigen::Vector3d(-0.1875, -0.0375, -0.0375)));
  EXPECT_TRUE(set.positions_m[1].isApprox(Eigen::Vector3d(-0.1625, -0.0375, -0.0375)));
  EXPECT_NEAR(volume_sum(set), 0.004, 1e-15);
  // A voxel in the middle keeps its full volume.
  EXPECT_NEAR(set.volumes_m3[8 + 16 * (2 + 4 * 2)], std::pow(0.025, 3), 1e-3 * std::pow(0.025, 3));
}

TEST(SampleParticles, DensityCountsVoxelsAlongTheLongestSide) {
  const ParticleSet set = sample_particles(box_mesh({0.3, 0.2, 0.1}));
  EXPECT_DOUBLE_EQ(set.spacing_m, 0.02);
  EXPECT_EQ(std::count(set.on_surface.begin(), set.on_surface.end(), false), 15 * 10 * 5);
}

TEST(SampleParticles, FollowTheRuleOnARoundBody) {
  const TriangleMesh mesh = sphere_mesh(0.1, 4);
  const ParticleSet set = sample_particles(mesh);
  const double h = 0.2 / 15, half_diagonal = 0.5 * std::sqrt(3.0) * h;
  EXPECT_NEAR(set.spacing_m, h, 1e-12);
  for (size_t i = 0; i < set.positions_m.size(); ++i) {
    EXPECT_LT(set.positions_m[i].norm(), 0.1 + 1e-12);
    EXPECT_GT(set.volumes_m3[i], 0.0);
    if (set.on_surface[i]) {
      EXPECT_NEAR(set.positions_m[i].norm(), 0.1, 1e-12);
      for (size_t j = 0; j < i; ++j) {
        EXPECT_GE((set.positions_m[i] - set.positions_m[j]).norm(), half_diagonal * (1 - 1e-6));
      }
    }
  }
  EXPECT_NEAR(volume_sum(set), signed_volume_m3(mesh), 1e-12);
  // Every mesh vertex that the rule admits was taken.
  for (const auto& vertex : mesh.vertices_m) {
    double nearest = 1.0;
    for (const auto& p : set.positions_m) nearest = std::min(nearest, (p - vertex).norm());
    EXPECT_LT(nearest, half_diagonal);
  }
  // The mass distribution matches the body: the second moment is that of the solid within the discretisation
  // error (h²/12 of 0.02 R²).
  double second = 0.0;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < set.positions_m.size(); ++i) {
    second += set.volumes_m3[i] * set.positions_m[i].squaredNorm();
    centre += set.volumes_m3[i] * set.positions_m[i];
  }
  EXPECT_NEAR(second / volume_sum(set) / (0.6 * 0.01), 1.0, 0.03);
  EXPECT_LT(centre.norm() / volume_sum(set), 0.02 * h);
}

TEST(SampleParticles, ThinSheetIsSampledOnItsSurface) {
  // A plate whose only voxel layer has its centres outside it, and whose corners are a metre apart.
  const ParticleSet set = sample_particles(box_mesh({1.0, 0.01, 1.0}));
  EXPECT_EQ(std::count(set.on_surface.begin(), set.on_surface.end(), false), 0);
  EXPECT_TRUE(set.surface_carries);
  EXPECT_EQ(set.piece_count, 1);
  EXPECT_NEAR(volume_sum(set), 0.01, 1e-15);
  // Each point of the plate is within a voxel of a particle, and no particle has much more than its share.
  const double share_m3 = 0.01 / static_cast<double>(set.positions_m.size());
  EXPECT_LT(*std::max_element(set.volumes_m3.begin(), set.volumes_m3.end()), 4.0 * share_m3);
  for (double x = -0.49; x < 0.5; x += 0.07) {
    for (double z = -0.49; z < 0.5; z += 0.07) {
      double nearest_m = 1.0;
      for (const auto& p : set.positions_m)
        nearest_m = std::min(nearest_m, (p - Eigen::Vector3d(x, 0, z)).norm());
      EXPECT_LT(nearest_m, set.spacing_m) << x << ' ' << z;
    }
  }
}

TEST(SampleParticles, ConnectedBodiesGetNoSurfacePoints) {
  for (const TriangleMesh& mesh :
       {box_mesh({0.4, 0.1, 0.1}), sphere_mesh(0.1, 3), cylinder_mesh(0.05, 0.2), capsule_mesh(0.05, 0.2)}) {
    EXPECT_FALSE(sample_particles(mesh).surface_carries);
  }
}

TEST(SampleParticles, AreNeverEmpty) {
  const ParticleSet set = sample_particles(sphere_mesh(0.01, 0), 1, 10.0);
  EXPECT_GE(set.positions_m.size(), 1u);
  EXPECT_NEAR(volume_sum(set), signed_volume_m3(sphere_mesh(0.01, 0)), 1e-18);
}

TEST(SampleParticles, EnlargesATinySpacing) {
  const ParticleSet set = sample_particles(box_mesh({1e-4, 1, 1e-4}), kDefaultSamplingDensity, 1e-7);
  EXPECT_GT(set.spacing_m, 1e-6);
}

}  // namespace
}  // namespace livegs
