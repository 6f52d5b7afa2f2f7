// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "physics/lattice/lattice.h"
#include "scenes/elastic_bodies.h"

// Several materials in one lattice. Closed forms are box volumes.

namespace livegs {
namespace {

using test::particle_grid;
using test::Vector3d;

BodyRegion made_of(const Vector3d& min_m, const Vector3d& max_m) {
  BodyRegion region;
  region.min_m = min_m;
  region.max_m = max_m;
  region.material.emplace();
  return region;
}

double part_of(const LatticeCell& cell, uint16_t material) {
  for (const MaterialShare& share : cell.materials) {
    if (share.material == material) return share.part;
  }
  return 0.0;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(LatticeMaterials, SingleMaterialFillsTheBody) {
  const Lattice lattice = build_lattice(measure_extent(particle_grid({0.4, 0.1, 0.1}, 0.0125)), 0.025, {});
  for (const LatticeCell& cell : lattice.cells) {
    ASSERT_EQ(cell.materials.size(), 1u);
    EXPECT_EQ(cell.materials[0].material, 0);
    EXPECT_DOUBLE_EQ(cell.materials[0].part, 1.0);
  }
  ASSERT_EQ(lattice.material_volumes_m3.size(), 1u);
  EXPECT_NEAR(lattice.material_volumes_m3[0], 0.004, 1e-15);
  EXPECT_EQ(lattice.material_node_volumes_m3[0], lattice.node_volumes_m3);
}

TEST(LatticeMaterials, CellAcrossAFaceIsCutExactly) {
  // The face at 13 mm is 13/25 into a column of cells and 0.5 mm into a layer of particles.
  const std::vector<BodyRegion> regions = {made_of({0.013, -1, -1}, {1, 1, 1})};
  const Lattice lattice =
      build_lattice(measure_extent(particle_grid({0.4, 0.1, 0.1}, 0.0125)), 0.025, regions);
  int across = 0;
  for (const LatticeCell& cell : lattice.cells) {
    const double low = lattice.node_position_m(cell.nodes[0]).x();
    const double part = std::clamp((low + 0.025 - 0.013) / 0.025, 0.0, 1.0);
    EXPECT_NEAR(part_of(cell, 1), part, 1e-12);
    EXPECT_NEAR(part_of(cell, 0), 1.0 - part, 1e-12);
    EXPECT_EQ(cell.materials.size(), part > 0.0 && part < 1.0 ? 2u : 1u);
    EXPECT_TRUE(std::is_sorted(cell.materials.begin(), cell.materials.end(),
                               [](const auto& a, const auto& b) { return a.material < b.material; }));
    across += cell.materials.size() == 2;
  }
  EXPECT_EQ(across, 16);
  EXPECT_NEAR(lattice.material_volumes_m3[0], 0.213 * 0.01, 1e-15);
  EXPECT_NEAR(lattice.material_volumes_m3[1], 0.187 * 0.01, 1e-15);
}

TEST(LatticeMaterials, NodesCarryVolumeAndMomentOfEachMaterial) {
  const std::vector<BodyRegion> regions = {made_of({0.013, -1, -1}, {1, 1, 1})};
  const Lattice lattice =
      build_lattice(measure_extent(particle_grid({0.4, 0.1, 0.1}, 0.0125)), 0.025, regions);
  const double centres[2] = {-0.5 * (0.2 - 0.013), 0.5 * (0.013 + 0.2)};
  for (int material = 0; material < 2; ++material) {
    const std::vector<double>& volumes = lattice.material_node_volumes_m3[material];
    EXPECT_NEAR(sum(volumes), lattice.material_volumes_m3[material], 1e-15);
    double moment = 0.0;
    for (size_t i = 0; i < volumes.size(); ++i) moment += volumes[i] * lattice.node_position_m(i).x();
    EXPECT_NEAR(moment / sum(volumes), centres[material], 1e-12);
  }
  for (size_t i = 0; i < lattice.node_volumes_m3.size(); ++i) {
    EXPECT_NEAR(lattice.material_node_volumes_m3[0][i] + lattice.material_node_volumes_m3[1][i],
                lattice.node_volumes_m3[i], 1e-18);
  }
}

TEST(LatticeMaterials, LaterRegionWinsAndOnlyMaterialsAreNumbered) {
  BodyRegion pulled;  // has no material and therefore no number
  pulled.min_m = {0.19, -1, -1};
  pulled.max_m = {1, 1, 1};
  pulled.traction_pa = {1, 0, 0};
  const std::vector<BodyRegion> regions = {made_of({-0.1, -1, -1}, {0.1, 1, 1}), pulled,
                                           made_of({0.05, -1, -1}, {1, 1, 1})};
  const Lattice lattice =
      build_lattice(measure_extent(particle_grid({0.4, 0.1, 0.1}, 0.0125)), 0.025, regions);
  ASSERT_EQ(lattice.material_volumes_m3.size(), 3u);
  EXPECT_NEAR(lattice.material_volumes_m3[0], 0.1 * 0.01, 1e-15);
  EXPECT_NEAR(lattice.material_volumes_m3[1], 0.15 * 0.01, 1e-15);
  EXPECT_NEAR(lattice.material_volumes_m3[2], 0.15 * 0.01, 1e-15);
}

TEST(LatticeMaterials, RotatedLatticeCutsWithinAnEighthOfABox) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.5, Vector3d(1, 2, 3).normalized()));
  ParticleSet particles = particle_grid({0.4, 0.12, 0.08}, 0.02);
  for (Vector3d& p : particles.positions_m) p = turn * p;
  // A plane through the centre halves the bar.
  const std::vector<BodyRegion> regions = {made_of({0, -1, -1}, {1, 1, 1})};
  const Lattice lattice = build_lattice(measure_extent(particles), 0.04, regions);
  const double volume = 0.4 * 0.12 * 0.08;
  EXPECT_NEAR(lattice.material_volumes_m3[0] + lattice.material_volumes_m3[1], volume, 1e-12);
  // Boxes are cut into pieces with edges of 5 mm. The plane cuts an area of about 0.12 x 0.08 / cos.
  EXPECT_NEAR(lattice.material_volumes_m3[1], 0.5 * volume, 0.0025 * 0.12 * 0.08);
  EXPECT_NEAR(sum(lattice.material_node_volumes_m3[1]), lattice.material_volumes_m3[1], 1e-12);
}

TEST(LatticeMaterials, FixedRegionMayHaveItsOwnMaterial) {
  BodyRegion clamp = made_of({-0.2, -0.05, -0.05}, {-0.15, 0.05, 0.05});
  clamp.fixed = true;
  const Lattice lattice = build_lattice(measure_extent(particle_grid({0.4, 0.1, 0.1}, 0.0125)), 0.025,
                                        std::vector<BodyRegion>{clamp});
  for (const LatticeCell& cell : lattice.cells) EXPECT_EQ(cell.fixed, part_of(cell, 1) == 1.0);
}

}  // namespace
}  // namespace livegs
