// SPDX-License-Identifier: Apache-2.0
#include "geometry/reconstruct_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>

#include "core/parallel_for.h"
#include "geometry/field/distance_field.h"
#include "server/geometry/mesh/mesh_checks.h"
#include "server/geometry/surface/point_clouds.h"

namespace livegs {
namespace {

using std::numbers::pi;
using namespace testing;

Surface surface_of(const Points& points, const SurfaceOptions& options = elastic_surface_options()) {
  auto surface = reconstruct_surface(points, options);
  EXPECT_TRUE(surface) << surface.error().message;
  expect_body(surface->mesh);
  return *surface;
}

// Surfaces of points on a smooth shape lie inside it by the sagitta of an edge. With voxels of 0.01 diagonal
// (a third of the radius) the error is about 1e-3. Tetrahedra that the ball removes from a flat side have
// about the same effect.
TEST(ReconstructSurface, Sphere) {
  const Surface surface = surface_of(sphere_cloud(30000, 0.1));
  EXPECT_EQ(surface.source, SurfaceSource::AlphaShape);
  EXPECT_EQ(surface.note, "");
  EXPECT_NEAR(surface.alpha_radius_m, 0.03 * 0.1 * 2 * std::sqrt(3.0), 1e-4);
  EXPECT_EQ(mesh_topology(surface.mesh).euler_characteristic, 2);
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / (4.0 / 3.0 * pi * 1e-3), 1.0, 0.01);
}

TEST(ReconstructSurface, Cube) {
  const Surface surface = surface_of(cube_cloud(30000, 0.1));
  EXPECT_EQ(mesh_topology(surface.mesh).euler_characteristic, 2);
  // Edges are rounded by at most the radius: 12 edges of (1 - pi/4) R². Here points lie 1e-3 from them.
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / 8e-3, 1.0, 0.02);
}

TEST(ReconstructSurface, TorusKeepsItsHole) {
  const Surface surface = surface_of(torus_cloud(40000, 0.1, 0.03));
  EXPECT_EQ(mesh_topology(surface.mesh).euler_characteristic, 0);
  EXPECT_EQ(mesh_topology(surface.mesh).piece_count, 1);
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / (2 * pi * pi * 0.1 * 0.0009), 1.0, 0.02);
}

TEST(ReconstructSurface, Capsule) {
  const Surface surface = surface_of(capsule_cloud(30000, 0.05, 0.2));
  EXPECT_EQ(mesh_topology(surface.mesh).euler_characteristic, 2);
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / (pi * 0.0025 * 0.2 + 4.0 / 3.0 * pi * 1.25e-4), 1.0, 0.02);
}

TEST(ReconstructSurface, RigidOptionsKeepTheVolume) {
  const Surface surface = surface_of(sphere_cloud(30000, 0.1), rigid_surface_options());
  EXPECT_LT(surface.mesh.triangles.size(), 8000u);
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / (4.0 / 3.0 * pi * 1e-3), 1.0, 0.02);
}

TEST(ReconstructSurface, LargerRadiusClosesSparseSurfaces) {
  // 300 points on a sphere: the gaps are a tenth of the diagonal, so the paper's ball would enter.
  const Surface surface = surface_of(sphere_cloud(300, 0.1));
  EXPECT_EQ(surface.source, SurfaceSource::LargerAlphaShape);
  EXPECT_NE(surface.note, "");
  // Inscribed with edges of 0.2 r: the volume is up to a few per cent smaller.
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / (4.0 / 3.0 * pi * 1e-3), 1.0, 0.06);
}

TEST(ReconstructSurface, FlatCloudBecomesASheet) {
  const Points points = cloud(8000, 6, [](Random& r) {
    const double x = r.uniform(-0.1, 0.1), z = r.uniform(-0.1, 0.1);
    return Eigen::Vector3d(x, 0.3, z);
  });
  const Surface surface = surface_of(points);
  EXPECT_EQ(surface.source, SurfaceSource::AlphaShape);
  const double thickness = 0.1 * surface.alpha_radius_m;
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / (0.04 * thickness), 1.0, 0.05);
  EXPECT_NEAR(mesh_bounds_m(surface.mesh).sizes().y(), thickness, 1e-9);
}

TEST(ReconstructSurface, BentSheetKeepsItsShape) {
  // A half-pipe: no volume of its own, open to one side.
  const Points points = cloud(20000, 8, [](Random& r) {
    const double turn = r.uniform(0, pi), along = r.uniform(-0.1, 0.1);
    return Eigen::Vector3d(0.1 * std::cos(turn), 0.1 * std::sin(turn), along);
  });
  const Surface surface = surface_of(points);
  EXPECT_EQ(mesh_topology(surface.mesh).piece_count, 1);
  const double sheet_m3 = pi * 0.1 * 0.2 * 0.1 * surface.alpha_radius_m;
  EXPECT_NEAR(signed_volume_m3(surface.mesh) / sheet_m3, 1.0, 0.15);
}

TEST(ReconstructSurface, BowlStaysOpen) {
  const Surface surface = surface_of(bowl_cloud(20000, 0.1));
  EXPECT_EQ(mesh_topology(surface.mesh).piece_count, 1);
  EXPECT_LT(signed_volume_m3(surface.mesh), 0.1 * 2.0 / 3.0 * pi * 1e-3);
  EXPECT_GT(DistanceField(surface.mesh, 0.005, 0.01).sample({0, -0.05, 0}).distance_m, 0.04);
}

TEST(ReconstructSurface, TwoBodiesStaySeparate) {
  Points points = sphere_cloud(8000, 0.05);
  for (const auto& p : sphere_cloud(8000, 0.05)) points.push_back(p + Eigen::Vector3d(0.3, 0, 0));
  const Surface surface = surface_of(points);
  EXPECT_EQ(mesh_topology(surface.mesh).piece_count, 2);
  EXPECT_NE(surface.note.find("2 pieces"), std::string::npos) << surface.note;
}

// Thinning makes reconstruction fast: only the points that the shape needs are triangulated.
TEST(ReconstructSurface, ThinningKeepsTheShape) {
  const struct {
    const char* name;
    Points points;
  } cases[] = {{"noisy sphere", sphere_cloud(25000, 0.1, 0.001)},
               {"noisy torus", torus_cloud(25000, 0.1, 0.03, 0.001)},
               {"cube", cube_cloud(20000, 0.1)}};
  for (const auto& [name, points] : cases) {
    SCOPED_TRACE(name);
    const Surface thinned = surface_of(points);
    const Surface whole = surface_of(points, {.alpha_radius = 0.03, .downsample = 1e-5});
    EXPECT_LT(thinned.mesh.vertices_m.size(), whole.mesh.vertices_m.size());
    EXPECT_NEAR(signed_volume_m3(thinned.mesh) / signed_volume_m3(whole.mesh), 1.0, 0.02);
    // Hausdorff distance between the surfaces, from the vertices of each to the surface of the other: half
    // the alpha radius. A cell of the fields is half a radius; near the surface their error is a small part
    // of it.
    const double radius_m = whole.alpha_radius_m;
    const DistanceField to_whole(whole.mesh, 0.5 * radius_m, radius_m);
    const DistanceField to_thinned(thinned.mesh, 0.5 * radius_m, radius_m);
    double worst = 0.0;
    for (const auto& v : thinned.mesh.vertices_m)
      worst = std::max(worst, std::abs(to_whole.sample(v).distance_m));
    for (const auto& v : whole.mesh.vertices_m)
      worst = std::max(worst, std::abs(to_thinned.sample(v).distance_m));
    EXPECT_LT(worst, 0.5 * radius_m);
    std::printf("%-13s triangles %zu -> %zu, volume %+.2f %%, Hausdorff %.2f alpha radius\n", name,
                whole.mesh.triangles.size(), thinned.mesh.triangles.size(),
                100 * (signed_volume_m3(thinned.mesh) / signed_volume_m3(whole.mesh) - 1), worst / radius_m);
  }
}

// A closed body, and one of sheets with thickened points. Memory allocated in between changes the addresses
// in the triangulation.
TEST(ReconstructSurface, IsBitEqualForAnyThreadCount) {
  for (const Points& points : {torus_cloud(10000, 0.1, 0.03, 0.002), bowl_cloud(5000, 0.1)}) {
    const Surface first = surface_of(points);
    std::vector<std::unique_ptr<std::vector<char>>> ballast;
    for (int threads : {1, 2, 4, 1, 2, 4}) {
      for (size_t size = 100; size < 100000; size *= 3) {
        ballast.push_back(std::make_unique<std::vector<char>>(size * ballast.size()));
      }
      set_thread_count(threads);
      const Surface again = surface_of(points);
      ASSERT_TRUE(again.mesh.triangles == first.mesh.triangles);
      ASSERT_EQ(again.mesh.vertices_m.size(), first.mesh.vertices_m.size());
      EXPECT_EQ(std::memcmp(again.mesh.vertices_m.data(), first.mesh.vertices_m.data(),
                            first.mesh.vertices_m.size() * sizeof(Eigen::Vector3d)),
                0);
    }
  }
  set_thread_count(0);
}

TEST(ReconstructSurface, DoesNotDependOnUnitOrPosition) {
  const Points points = torus_cloud(10000, 0.1, 0.03, 0.002);
  const double volume = signed_volume_m3(surface_of(points).mesh);
  for (double scale : {1e-3, 1e3}) {
    Points moved_points;
    for (const auto& p : points) moved_points.push_back(scale * (p + Eigen::Vector3d(10, -5, 3)));
    const Surface surface = surface_of(moved_points);
    // A point within rounding of a voxel boundary may change voxels, so that another point is kept.
    EXPECT_NEAR(signed_volume_m3(surface.mesh) / (scale * scale * scale) / volume, 1.0, 1e-3);
  }
}

}  // namespace
}  // namespace livegs
