// SPDX-License-Identifier: Apache-2.0
#include "physics/lattice/region_load.h"

#include <gtest/gtest.h>

#include "geometry/surface/shape_mesh.h"
#include "scenes/elastic_bodies.h"

namespace livegs {
namespace {

using test::particle_grid;
using test::Vector3d;

struct Face {
  double area_m2 = 0.0;
  Vector3d centre_m = Vector3d::Zero();
  double least_m[3] = {1, 1, 1}, most_m[3] = {-1, -1, -1};
};

Face face_of(const ParticleSet& particles, double width_m, const BodyRegion& region) {
  const BodyExtent extent = measure_extent(particles);
  const Lattice lattice = build_lattice(extent, width_m, {});
  Face face;
  for (const LoadPoint& load : load_points(particles, extent, lattice, region)) {
    const auto weights = trilinear_weights(load.point.local);
    Vector3d point = Vector3d::Zero();
    for (int c = 0; c < 8; ++c)
      point += weights[c] * lattice.node_position_m(lattice.cells[load.point.cell].nodes[c]);
    face.area_m2 += load.area_m2;
    face.centre_m += load.area_m2 * point;
    for (int d = 0; d < 3; ++d) {
      face.least_m[d] = std::min(face.least_m[d], point[d]);
      face.most_m[d] = std::max(face.most_m[d], point[d]);
    }
  }
  face.centre_m /= face.area_m2;
  return face;
}

BodyRegion box(const Vector3d& min_m, const Vector3d& max_m) {
  BodyRegion region;
  region.min_m = min_m;
  region.max_m = max_m;
  return region;
}

TEST(RegionLoad, BarEndLoadsItsWholeFace) {
  for (const double side : {1.0, -1.0}) {
    const BodyRegion end = side > 0 ? box({0.19, -1, -1}, {1, 1, 1}) : box({-1, -1, -1}, {-0.19, 1, 1});
    const Face face = face_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, end);
    EXPECT_NEAR(face.area_m2, 0.01, 1e-15);
    EXPECT_NEAR(face.least_m[0], side * 0.2, 1e-15);
    EXPECT_NEAR(face.most_m[0], side * 0.2, 1e-15);
    EXPECT_NEAR((face.centre_m - Vector3d(side * 0.2, 0, 0)).norm(), 0.0, 1e-15);
  }
}

// Boxes sampled as in scenes: the voxels do not divide the size evenly.
TEST(RegionLoad, SampledBoxEndLoadsItsWholeFace) {
  for (const Vector3d& size : {Vector3d(0.4, 0.1, 0.1), Vector3d(0.3, 0.07, 0.07), Vector3d(1.0, 0.3, 0.3),
                               Vector3d(0.35, 0.13, 0.09)}) {
    for (const double thickness_m : {0.01, 0.03}) {
      const Face face = face_of(sample_particles(box_mesh(size)), 0.04,
                                box({0.5 * size.x() - thickness_m, -1, -1}, {1, 1, 1}));
      EXPECT_NEAR(face.area_m2 / (size.y() * size.z()), 1.0, 0.005)
          << size.transpose() << ", " << thickness_m << " m";
    }
  }
}

// These bodies are thinner than a voxel, and their particles lie on their faces. Cells have the default
// width, 71 mm here.
TEST(RegionLoad, SubVoxelBodyLoadsItsWholeFace) {
  for (const double thick_m : {0.0005, 0.003, 0.01, 0.02}) {
    const ParticleSet plate = sample_particles(box_mesh({0.5, 0.5, thick_m}));
    const Face face = face_of(plate, 0.071, box({-1, -1, 0.4 * thick_m}, {1, 1, 1}));
    EXPECT_NEAR(face.area_m2 / 0.25, 1.0, 0.005) << thick_m;
    EXPECT_NEAR((face.centre_m - Vector3d(0, 0, 0.5 * thick_m)).norm(), 0.0, 1e-6) << thick_m;
    const Face end = face_of(plate, 0.071, box({0.25 - 0.2 * thick_m, -1, -1}, {1, 1, 1}));
    EXPECT_NEAR(end.area_m2 / (0.5 * thick_m), 1.0, 0.005) << thick_m;
  }
  const Face rod =
      face_of(sample_particles(box_mesh({0.4, 0.01, 0.01})), 0.05, box({0.195, -1, -1}, {1, 1, 1}));
  EXPECT_NEAR(rod.area_m2 / 1e-4, 1.0, 0.005);
  const Face bar = face_of(sample_particles(box_mesh({2.4, 0.1, 0.1})), 0.3, box({1.15, -1, -1}, {9, 1, 1}));
  EXPECT_NEAR(bar.area_m2 / 1e-2, 1.0, 0.005);
}

TEST(RegionLoad, RoundFaceMatchesTheMesh) {
  // The mesh is a prism of 32 sides; its section is 0.9936 of the circle's.
  const double section_m2 = 16.0 * std::sin(2.0 * M_PI / 32.0) * 0.05 * 0.05;
  for (const double height_m : {0.4, 2.0}) {
    const ParticleSet cylinder = sample_particles(cylinder_mesh(0.05, height_m, 32));
    const Face end = face_of(cylinder, 0.1, box({-1, 0.5 * height_m - 0.05, -1}, {1, 9, 1}));
    EXPECT_NEAR(end.area_m2 / section_m2, 1.0, 0.005) << height_m;
  }
}

TEST(RegionLoad, PartOfAFaceIsCutExactly) {
  // The region's edges are inside particles and cells, and it is thinner than a particle.
  const Face face =
      face_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, box({0.195, -1, -1}, {1, 0.013, 1}));
  EXPECT_NEAR(face.area_m2, 0.063 * 0.1, 1e-15);
  EXPECT_NEAR((face.centre_m - Vector3d(0.2, 0.5 * (0.013 - 0.05), 0)).norm(), 0.0, 1e-14);
}

TEST(RegionLoad, InnerSlabLoadsItsFaceNearerToTheEnd) {
  const Face face = face_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, box({0.10, -1, -1}, {0.12, 1, 1}));
  EXPECT_NEAR(face.area_m2, 0.01, 1e-15);
  EXPECT_NEAR(face.centre_m.x(), 0.12, 1e-14);
}

TEST(RegionLoad, RotatedLatticeLoadsTheSameFace) {
  // A bar rotated about y by 30 degrees, with its lattice along it; the load acts on its upper 20 mm.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI / 6, Vector3d::UnitY()));
  ParticleSet particles = particle_grid({0.4, 0.08, 0.12}, 0.02);
  for (Vector3d& p : particles.positions_m) p = turn * p;
  const Face face = face_of(particles, 0.04, box({-1, 0.02, -1}, {1, 1, 1}));
  EXPECT_NEAR(face.area_m2, 0.4 * 0.12, 1e-9);
  EXPECT_NEAR((face.centre_m - Vector3d(0, 0.04, 0)).norm(), 0.0, 1e-9);
}

TEST(RegionLoad, RegionOutsideTheBodyHasNoLoad) {
  for (const ParticleSet& particles :
       {particle_grid({0.4, 0.1, 0.1}, 0.0125), sample_particles(box_mesh({0.4, 0.1, 0.1}))}) {
    const BodyExtent extent = measure_extent(particles);
    const Lattice lattice = build_lattice(extent, 0.025, {});
    EXPECT_TRUE(load_points(particles, extent, lattice, box({0.3, -1, -1}, {1, 1, 1})).empty());
  }
}

}  // namespace
}  // namespace livegs
