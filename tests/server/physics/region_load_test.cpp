// SPDX-License-Identifier: Apache-2.0
#include "physics/region_load.h"

#include <gtest/gtest.h>

#include "geometry/shape_mesh.h"
#include "server/physics/elastic_bodies.h"

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
  for (const LoadPoint& load : load_points(extent, lattice, region)) {
    const auto weights = trilinear_weights(load.point.local);
    Vector3d point = Vector3d::Zero();
    for (int c = 0; c < 8; ++c) point += weights[c] * lattice.node_position_m(lattice.cells[load.point.cell].nodes[c]);
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

TEST(RegionLoad, AnEndOfABarIsItsWholeFace) {
  for (const double side : {1.0, -1.0}) {
    const BodyRegion end = side > 0 ? box({0.19, -1, -1}, {1, 1, 1}) : box({-1, -1, -1}, {-0.19, 1, 1});
    const Face face = face_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, end);
    EXPECT_NEAR(face.area_m2, 0.01, 1e-15);
    EXPECT_NEAR(face.least_m[0], side * 0.2, 1e-15);
    EXPECT_NEAR(face.most_m[0], side * 0.2, 1e-15);
    EXPECT_NEAR((face.centre_m - Vector3d(side * 0.2, 0, 0)).norm(), 0.0, 1e-15);
  }
}

// As scenes sample boxes: voxels that do not fit across them.
TEST(RegionLoad, AnEndOfASampledBoxIsItsWholeFace) {
  for (const Vector3d& size : {Vector3d(0.4, 0.1, 0.1), Vector3d(0.3, 0.07, 0.07), Vector3d(1.0, 0.3, 0.3),
                               Vector3d(0.35, 0.13, 0.09)}) {
    for (const double thickness_m : {0.01, 0.03}) {
      const Face face = face_of(sample_particles(box_mesh(size)), 0.04, box({0.5 * size.x() - thickness_m, -1, -1}, {1, 1, 1}));
      EXPECT_NEAR(face.area_m2 / (size.y() * size.z()), 1.0, 0.005) << size.transpose() << ", " << thickness_m << " m";
    }
  }
}

TEST(RegionLoad, APartOfAFaceIsCutExactly) {
  // Edges inside particles and cells; thinner than a particle.
  const Face face = face_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, box({0.195, -1, -1}, {1, 0.013, 1}));
  EXPECT_NEAR(face.area_m2, 0.063 * 0.1, 1e-15);
  EXPECT_NEAR((face.centre_m - Vector3d(0.2, 0.5 * (0.013 - 0.05), 0)).norm(), 0.0, 1e-14);
}

TEST(RegionLoad, TheOuterFaceOfAnInnerSlabIsTheOneNearerToTheEnd) {
  const Face face = face_of(particle_grid({0.4, 0.1, 0.1}, 0.0125), 0.025, box({0.10, -1, -1}, {0.12, 1, 1}));
  EXPECT_NEAR(face.area_m2, 0.01, 1e-15);
  EXPECT_NEAR(face.centre_m.x(), 0.12, 1e-14);
}

TEST(RegionLoad, ARotatedLatticeLoadsTheSameFaceWithinAnEighthOfABox) {
  // A bar turned about y by 30 degrees, which the lattice follows; its upper 20 mm.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(M_PI / 6, Vector3d::UnitY()));
  ParticleSet particles = particle_grid({0.4, 0.08, 0.12}, 0.02);
  for (Vector3d& p : particles.positions_m) p = turn * p;
  const Face face = face_of(particles, 0.04, box({-1, 0.02, -1}, {1, 1, 1}));
  EXPECT_NEAR(face.area_m2, 0.4 * 0.12, 1e-9);
  EXPECT_NEAR((face.centre_m - Vector3d(0, 0.04, 0)).norm(), 0.0, 1e-9);
}

TEST(RegionLoad, ARegionBesideTheBodyHasNone) {
  const BodyExtent extent = measure_extent(particle_grid({0.4, 0.1, 0.1}, 0.0125));
  const Lattice lattice = build_lattice(extent, 0.025, {});
  EXPECT_TRUE(load_points(extent, lattice, box({0.3, -1, -1}, {1, 1, 1})).empty());
}

}  // namespace
}  // namespace livegs
