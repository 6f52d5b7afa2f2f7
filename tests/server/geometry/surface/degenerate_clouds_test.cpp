// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/field/distance_field.h"
#include "geometry/field/sample_particles.h"
#include "geometry/mesh/mass_properties.h"
#include "geometry/reconstruct_surface.h"
#include "geometry/surface/mesh_facts.h"
#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

using namespace testing;

// Reconstructs the body of any cloud and checks all derived data.
Surface body_of(const Points& points) {
  Surface chosen;
  for (const SurfaceOptions& options : {rigid_surface_options(), elastic_surface_options()}) {
    auto surface = reconstruct_surface(points, options);
    EXPECT_TRUE(surface) << surface.error().message;
    if (!surface) return {};
    expect_body(surface->mesh);
    const ParticleSet particles = sample_particles(surface->mesh);
    EXPECT_GE(particles.positions_m.size(), 1u);
    const MassProperties mass = solid_mass_properties(surface->mesh);
    EXPECT_TRUE(mass.inertia_m2.allFinite());
    EXPECT_GT(mass.inertia_m2.determinant(), 0.0);
    const double longest = mesh_bounds_m(surface->mesh).sizes().maxCoeff();
    const DistanceField field(surface->mesh, longest / 16, longest / 8);
    EXPECT_TRUE(std::isfinite(field.sample(mass.centre_of_mass_m).distance_m));
    const MeshFacts facts = mesh_facts(surface->mesh);
    EXPECT_TRUE(facts.principal_size_m.allFinite());
    for (double score : {facts.solidity, facts.openness, facts.thin_sheet, facts.rod}) {
      EXPECT_GE(score, 0.0);
      EXPECT_LE(score, 1.0);
    }
    chosen = *surface;
  }
  return chosen;
}

TEST(DegenerateClouds, OnePoint) {
  const Surface surface = body_of({{1, 2, 3}});
  EXPECT_EQ(surface.source, SurfaceSource::Box);
  EXPECT_TRUE(mesh_bounds_m(surface.mesh).center().isApprox(Eigen::Vector3d(1, 2, 3)));
  EXPECT_NE(surface.note, "");
}

TEST(DegenerateClouds, CoincidentPoints) {
  EXPECT_EQ(body_of(Points(5000, Eigen::Vector3d(-4, 0.1, 7))).source, SurfaceSource::Box);
}

TEST(DegenerateClouds, TwoPoints) {
  const Surface surface = body_of({{0, 0, 0}, {0.1, 0.1, 0.1}});
  EXPECT_EQ(surface.source, SurfaceSource::Box);
  // A rod along the diagonal, not a cube around it.
  EXPECT_LT(signed_volume_m3(surface.mesh), 0.01 * 1e-3);
}

TEST(DegenerateClouds, CollinearPoints) {
  const Surface exact =
      body_of(cloud(500, 1, [](Random& r) { return Eigen::Vector3d(0.2, r.uniform(-1, 1), 0.5); }));
  EXPECT_EQ(exact.source, SurfaceSource::Box);
  // Off the axes, rounding moves the points off the line by 1e-17. The result is a thin box or thread.
  const Surface rounded = body_of(cloud(
      500, 1, [](Random& r) { return Eigen::Vector3d(r.uniform(-1, 1) * Eigen::Vector3d(0.3, 0.1, -0.2)); }));
  const double length_m = 2 * std::sqrt(0.14);
  EXPECT_LT(signed_volume_m3(rounded.mesh), length_m * std::pow(0.02 * length_m, 2) * 1.01);
}

TEST(DegenerateClouds, ThreeAndFourPoints) {
  body_of({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}});
  const Surface tetrahedron = body_of({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}});
  EXPECT_NEAR(signed_volume_m3(tetrahedron.mesh), 1e-3 / 6, 1e-9);
}

TEST(DegenerateClouds, CoplanarPoints) {
  body_of(cloud(2000, 2, [](Random& r) {
    const double u = r.uniform(), v = r.uniform();
    return Eigen::Vector3d(u * Eigen::Vector3d(0.2, 0.1, 0) + v * Eigen::Vector3d(0, 0.1, 0.3));
  }));
  body_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}});
}

TEST(DegenerateClouds, AlmostCoplanarAndAlmostCollinear) {
  for (double noise : {1e-15, 1e-12, 1e-9, 1e-6, 1e-3}) {
    SCOPED_TRACE(noise);
    body_of(cloud(2000, 3, [&](Random& r) {
      return Eigen::Vector3d(r.in_cube().cwiseProduct(Eigen::Vector3d(1, noise, 0.7)));
    }));
    body_of(cloud(500, 4, [&](Random& r) {
      return Eigen::Vector3d(r.in_cube().cwiseProduct(Eigen::Vector3d(1, noise, noise)));
    }));
  }
}

TEST(DegenerateClouds, ScatteredPoints) {
  for (size_t count : {5, 8, 13, 40, 200}) {
    SCOPED_TRACE(count);
    body_of(cloud(count, count, [](Random& r) { return r.in_cube(); }));
  }
}

TEST(DegenerateClouds, GridsWithManyCospericalPoints) {
  Points points;
  for (int x = 0; x < 12; ++x) {
    for (int y = 0; y < 12; ++y) {
      for (int z = 0; z < 12; ++z) points.emplace_back(0.05 * x, 0.05 * y, 0.05 * z);
    }
  }
  EXPECT_NEAR(signed_volume_m3(body_of(points).mesh), std::pow(0.55, 3), 0.05 * std::pow(0.55, 3));
}

TEST(DegenerateClouds, ExtremeRanges) {
  // A dense cluster and a point a million times as far away: the body is the line between them.
  Points points = cloud(1000, 5, [](Random& r) { return Eigen::Vector3d(1e-6 * r.in_cube()); });
  points.emplace_back(1, 1, 0);
  body_of(points);
  Points tiny = sphere_cloud(2000, 1e-12);
  body_of(tiny);
  Points huge = sphere_cloud(2000, 1e9);
  body_of(huge);
}

TEST(DegenerateClouds, InvalidCloudsAreErrors) {
  EXPECT_FALSE(reconstruct_surface({}, elastic_surface_options()));
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  for (double bad : {nan, infinity, 1e200}) {
    const auto surface =
        reconstruct_surface(Points{{0, 0, 0}, {bad, 0, 0}, {0, 1, 0}}, elastic_surface_options());
    ASSERT_FALSE(surface);
    EXPECT_EQ(surface.error().code, ErrorCode::InvalidData);
  }
  for (const SurfaceOptions& bad : {SurfaceOptions{.alpha_radius = 0.0}, SurfaceOptions{.alpha_radius = nan},
                                    SurfaceOptions{.alpha_radius = 0.03, .downsample = -1.0}}) {
    EXPECT_FALSE(reconstruct_surface(sphere_cloud(100, 1.0), bad));
  }
}

}  // namespace
}  // namespace livegs
